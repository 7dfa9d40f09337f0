//! Room for messages that are received, decoded and handled.
//!
//! A message takes its bytes before they are collected and what it will be in memory
//! before it is decoded ([`super::cost`]); a unary call keeps both until it is answered,
//! a stream until it asks for the next message. Small messages have a room of their
//! own, so that large ones cannot keep an update waiting.

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::cost::Shapes;
use crate::fault::Fault;
use crate::metrics::Metrics;
use crate::status;

/// Part of the byte budget that messages may have, and what they have at least.
const PART: u64 = 16;
const LEAST_BYTES: u64 = 24 << 20;
const MOST_BYTES: u64 = 256 << 20;
/// Part of it for small messages.
const SMALL_PART: usize = 4;
/// A message up to this size is small.
const SMALL_BYTES: usize = 16 << 10;
/// What one message may become, over the room for large ones.
const LARGEST_PART: u64 = 2;
/// Permits are counted in these.
const UNIT_BYTES: u64 = 1 << 10;
/// How long a message waits for room.
const PATIENCE: Duration = Duration::from_secs(10);

/// Room of one kind.
struct Room {
    free: Arc<Semaphore>,
    units: usize,
}

impl Room {
    fn new(bytes: u64) -> Self {
        let units = usize::try_from(bytes / UNIT_BYTES).unwrap_or(Semaphore::MAX_PERMITS);
        Self {
            free: Arc::new(Semaphore::new(units)),
            units,
        }
    }

    fn taken_bytes(&self) -> usize {
        (self.units - self.free.available_permits().min(self.units)) * UNIT_BYTES as usize
    }
}

/// The gate for messages.
pub(crate) struct Decode {
    small: Room,
    large: Room,
    largest: u64,
    pub(super) shapes: Shapes,
    metrics: Arc<Metrics>,
}

/// Room that a message has.
pub(super) struct Permit {
    _held: OwnedSemaphorePermit,
}

fn held(permit: OwnedSemaphorePermit) -> Permit {
    Permit { _held: permit }
}

impl Decode {
    pub(super) fn new(
        budget: u64,
        metrics: &Arc<Metrics>,
    ) -> Result<Arc<Self>, prost::DecodeError> {
        let bytes = (budget / PART).clamp(LEAST_BYTES, MOST_BYTES);
        let small = bytes / SMALL_PART as u64;
        Ok(Arc::new(Self {
            small: Room::new(small),
            large: Room::new(bytes - small),
            largest: (bytes - small) / LARGEST_PART,
            shapes: Shapes::new()?,
            metrics: Arc::clone(metrics),
        }))
    }

    fn room(&self, bytes: usize) -> &Room {
        match bytes <= SMALL_BYTES {
            true => &self.small,
            false => &self.large,
        }
    }

    /// Waits for room for the bytes of a message.
    pub(super) async fn receive(self: Arc<Self>, bytes: usize) -> Result<Permit, Fault> {
        let free = Arc::clone(&self.room(bytes).free);
        let waited = tokio::time::timeout(PATIENCE, free.acquire_many_owned(units(bytes as u64)));
        let permit = waited.await.ok().and_then(Result::ok);
        self.show();
        permit.map(held).ok_or_else(|| self.full(bytes as u64))
    }

    /// Takes what a message of `shape` will be in memory.
    ///
    /// # Errors
    /// `MessageLimit` for one that would be too large, `MemoryBudget` for one for which
    /// there is no room now: whoever waited here would hold what others wait for.
    pub(super) fn decode(&self, shape: usize, message: &[u8]) -> Result<Permit, Fault> {
        let cost = self.shapes.cost(shape, message, self.largest);
        if cost > self.largest {
            return Err(Fault::MessageLimit {
                what: "bytes that one message takes when it is decoded".to_owned(),
                limit: self.largest,
            });
        }
        let free = Arc::clone(&self.room(message.len().max(cost as usize / 16)).free);
        let permit = free.try_acquire_many_owned(units(cost)).ok();
        self.show();
        permit.map(held).ok_or_else(|| self.full(cost))
    }

    fn full(&self, bytes: u64) -> Fault {
        let taken = self.small.taken_bytes() + self.large.taken_bytes();
        Fault::MemoryBudget {
            predicted: bytes,
            held: taken as u64,
            budget: (self.small.units + self.large.units) as u64 * UNIT_BYTES,
        }
    }

    pub(super) fn show(&self) {
        let taken = self.small.taken_bytes() + self.large.taken_bytes();
        self.metrics.decoding(taken);
    }

    /// Counts a refused message.
    pub(super) fn refused(&self, fault: &Fault) {
        let reason = status::reason(fault);
        self.metrics.refused(reason);
        tracing::info!(reason, why = status::text(fault), "message refused");
    }
}

fn units(bytes: u64) -> u32 {
    u32::try_from(bytes.div_ceil(UNIT_BYTES)).unwrap_or(u32::MAX)
}
