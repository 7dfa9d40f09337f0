//! What a session counts against the byte budget of the server: its state, its
//! kept results, and those that only readers still hold. All numbers are bytes.

use std::sync::{Mutex, MutexGuard, PoisonError};

use signorini::LaterBytes;

use super::Actor;
use crate::fault::Fault;
use crate::uploads::store::Reservation;

impl Actor {
    /// Counts what is held, and never less than was predicted: the solver's
    /// scratch stays with the session. Where that does not fit, older results go.
    pub(super) fn account(&mut self) {
        let beside = self.held_bytes() - self.kept.bytes();
        let mut reservation = lock(&self.spec.reservation);
        if let Err(lacking) = reservation.resize(beside + self.kept.bytes()) {
            self.kept.free(lacking);
            reservation.force(beside + self.kept.bytes());
        }
    }

    /// All that the session holds now.
    pub(super) fn held_bytes(&self) -> u64 {
        let unread = self.writer.as_ref().map(|writer| &writer.reader.outbox);
        let unread_bytes = unread.map_or(0, |outbox| outbox.unread_bytes());
        let pinned = unread_bytes.saturating_sub(self.kept.bytes());
        let state = self.state_bytes.max(self.predicted_rest());
        let own = self.spec.own_bytes + self.saves.bytes() + self.path.bytes();
        own + pinned + state + self.response_bytes() + self.kept.bytes()
    }

    /// Whether the step after so many more than the accepted ones may make the body's response.
    fn comes_to_response(&self, more: u32) -> bool {
        let waiting = u32::try_from(self.queue.len()).unwrap_or(u32::MAX);
        let step = self.response.steps.saturating_add(waiting);
        self.later()
            .is_some_and(|later| step.saturating_add(more) >= later.from_step)
    }

    /// The session is there with what it accepted before, which was promised its memory.
    pub(super) fn note_response(&mut self) {
        self.is_response_due |= self.comes_to_response(0);
    }

    /// Takes the memory of the body's response before an update that may make it is accepted; what
    /// it does not need is given back with the first result.
    pub(super) fn claim_response(&mut self) -> Result<(), Fault> {
        if self.is_response_due || !self.comes_to_response(1) {
            return Ok(());
        }
        self.is_response_due = true;
        let held = self.held_bytes();
        let claimed = lock(&self.spec.reservation).claim(held);
        self.is_response_due = claimed.is_ok();
        claimed
    }

    /// What the response may still take: nothing before it is due, nor where it is there.
    fn response_bytes(&self) -> u64 {
        let is_to_come = self.is_response_due && !self.response.is_tried;
        let later = self.later().filter(|_| is_to_come);
        later.map_or(0, |later| later.bytes)
    }

    fn later(&self) -> Option<LaterBytes> {
        self.spec.plan.later_bytes()
    }

    /// Takes the memory of one more result before there is one. While it is lacking a
    /// writer has to read what it has; with nothing unread the newest result takes the
    /// place of older ones.
    pub(super) fn has_memory(&self) -> bool {
        let unread = self.writer.as_ref().map(|writer| &writer.reader.outbox);
        let unread_bytes = unread.map_or(0, |outbox| outbox.unread_bytes());
        let held = self.held_bytes();
        let next = self.spec.result_bytes;
        if lock(&self.spec.reservation).resize(held + next).is_ok() || unread_bytes == 0 {
            return true;
        }
        if let Some(outbox) = unread {
            outbox.await_empty();
        }
        false
    }

    /// The prediction without what is shared.
    fn predicted_rest(&self) -> u64 {
        let predicted = self.spec.plan.first_bytes();
        predicted.saturating_sub(self.shared_bytes())
    }

    fn shared_bytes(&self) -> u64 {
        let own = self.prepared.as_ref().map(|(lease, _)| lease);
        let found = own.or(self.spec.prepared.as_ref());
        found.map_or(0, |lease| lease.value().bytes())
    }

    /// What an increment may have to allocate: all but what is there already.
    pub(super) fn scratch_bytes(&self) -> u64 {
        let state = self.predicted_rest() + self.response_bytes();
        state.saturating_sub(self.state_bytes)
    }
}

/// The reservation; whole even if a holder of the lock panicked.
pub(super) fn lock(reservation: &Mutex<Reservation>) -> MutexGuard<'_, Reservation> {
    reservation.lock().unwrap_or_else(PoisonError::into_inner)
}
