//! Room for messages that are received, decoded and handled.
//!
//! A message takes its bytes before they are collected and what it will be in memory
//! before it is decoded ([`super::cost`]); a unary call keeps both until it is answered,
//! a stream until it asks for the next message. Small messages have a room of their
//! own, so that large ones cannot keep an update waiting.
//!
//! While a large message waits the transport holds as much of it as it lets a client send
//! ahead. That has a room of its own, of which one client has a part; who finds no place in it
//! is turned away.

use std::collections::HashMap;
use std::future::Future;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::cost::Shapes;
use crate::door::client_key::ClientIdentity;
use crate::fault::Fault;
use crate::fault::status;
use crate::watch::metrics::Metrics;

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
/// What a client may send ahead of what is read, of one stream.
pub(crate) const WINDOW_BYTES: u32 = 1 << 20;
/// Part of the room for large messages that those may have sent ahead which wait for it, and
/// part of that which one client may have.
const WAITING_PART: u64 = 4;
const CLIENT_PART: u64 = 2;
/// How long a message waits for room, and one without a place for its answer.
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

/// Bytes that the transport holds of large messages that wait, by client.
struct Waiting {
    by_client: Mutex<HashMap<ClientIdentity, u64>>,
    most: u64,
}

impl Waiting {
    /// A place for so many bytes, if there is one.
    fn enter(self: &Arc<Self>, client: ClientIdentity, bytes: u64) -> Option<Place> {
        let mut all = self
            .by_client
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let own = all.get(&client).copied().unwrap_or(0).saturating_add(bytes);
        let held: u64 = all.values().sum();
        let fits = own <= self.most / CLIENT_PART && held.saturating_add(bytes) <= self.most;
        fits.then(|| {
            all.insert(client, own);
            let room = Arc::clone(self);
            Place {
                room,
                client,
                bytes,
            }
        })
    }
}

/// A place among those that wait; given back on drop.
struct Place {
    room: Arc<Waiting>,
    client: ClientIdentity,
    bytes: u64,
}

impl Drop for Place {
    fn drop(&mut self) {
        let all = self.room.by_client.lock();
        let mut all = all.unwrap_or_else(PoisonError::into_inner);
        if let Some(own) = all.get_mut(&self.client) {
            *own = own.saturating_sub(self.bytes);
            if *own == 0 {
                all.remove(&self.client);
            }
        }
    }
}

/// What a message finds at the gate.
pub(super) enum Entry {
    Room(Permit),
    /// Others have the room; it may come.
    Waits(Pin<Box<dyn Future<Output = Result<Permit, Fault>> + Send>>),
    /// Too many wait already.
    Full(Fault),
}

/// The gate for messages.
pub(crate) struct Decode {
    small: Room,
    large: Room,
    waiting: Arc<Waiting>,
    /// How long a message waits for room, and one that was turned away for its answer.
    pub(super) patience: Duration,
    /// In which a request has to be there, beside what a slow line takes.
    pub(super) request_time: Duration,
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
        request_time: Duration,
        metrics: &Arc<Metrics>,
    ) -> Result<Arc<Self>, prost::DecodeError> {
        let bytes = (budget / PART).clamp(LEAST_BYTES, MOST_BYTES);
        let small = bytes / SMALL_PART as u64;
        Ok(Arc::new(Self {
            small: Room::new(small),
            large: Room::new(bytes - small),
            patience: PATIENCE,
            request_time,
            waiting: Arc::new(Waiting {
                by_client: Mutex::default(),
                most: (bytes - small) / WAITING_PART,
            }),
            largest: (bytes - small) / LARGEST_PART,
            shapes: Shapes::new()?,
            metrics: Arc::clone(metrics),
        }))
    }

    fn room(&self, bytes: usize) -> &Room {
        if bytes <= SMALL_BYTES {
            &self.small
        } else {
            &self.large
        }
    }

    /// Takes room for the bytes of a message of `client`, now or later.
    pub(super) fn receive(self: &Arc<Self>, client: ClientIdentity, bytes: usize) -> Entry {
        let free = Arc::clone(&self.room(bytes).free);
        let units = units(bytes as u64);
        // Nobody overtakes: what is given back goes to those who wait first.
        if let Ok(permit) = Arc::clone(&free).try_acquire_many_owned(units) {
            self.show();
            return Entry::Room(held(permit));
        }
        let ahead = match bytes <= SMALL_BYTES {
            // In its first frame.
            true => 0,
            false => (bytes as u64).min(u64::from(WINDOW_BYTES)),
        };
        let Some(place) = self.waiting.enter(client, ahead) else {
            return Entry::Full(self.full(bytes as u64));
        };
        let gate = Arc::clone(self);
        Entry::Waits(Box::pin(async move {
            let waited = tokio::time::timeout(gate.patience, free.acquire_many_owned(units)).await;
            drop(place);
            let permit = waited.ok().and_then(Result::ok);
            gate.show();
            permit.map(held).ok_or_else(|| gate.full(bytes as u64))
        }))
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

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: usize = WINDOW_BYTES as usize;

    fn user(number: u32) -> ClientIdentity {
        ClientIdentity::User(number)
    }

    #[tokio::test]
    async fn few_large_messages_wait_for_room_and_fewer_of_one_client() {
        let gate = Decode::new(0, PATIENCE, &Metrics::new().unwrap()).unwrap();
        let all = (gate.large.units as u64 * UNIT_BYTES) as usize;
        let Entry::Room(taken) = gate.receive(user(1), all) else {
            panic!("nobody has anything");
        };
        let mut waiting = Vec::new();
        for client in [1, 2] {
            while let Entry::Waits(room) = gate.receive(user(client), ONE) {
                waiting.push(room);
            }
        }
        let most = all as u64 / WAITING_PART / ONE as u64;
        assert_eq!(waiting.len() as u64, most / CLIENT_PART * 2);
        let full = gate.receive(user(1), ONE);
        assert!(matches!(full, Entry::Full(Fault::MemoryBudget { .. })));
        // Small ones have their own room, and may wait for it.
        let small = gate.small.units * UNIT_BYTES as usize / SMALL_BYTES;
        let mut held = Vec::new();
        for _ in 0..small {
            held.push(gate.receive(user(1), SMALL_BYTES));
        }
        assert!(held.iter().all(|one| matches!(one, Entry::Room(_))));
        assert!(matches!(
            gate.receive(user(1), SMALL_BYTES),
            Entry::Waits(_)
        ));
        drop(taken);
        for one in waiting {
            assert!(one.await.is_ok());
        }
        assert!(gate.waiting.by_client.lock().unwrap().is_empty());
        assert!(matches!(gate.receive(user(1), ONE), Entry::Room(_)));
    }
}
