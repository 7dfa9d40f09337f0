//! What a session counts against the byte budget of the server: its state, its
//! kept results, and those that only readers still hold. All numbers are bytes.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::Actor;
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
        let own = self.spec.own_bytes + self.saves.bytes();
        own + pinned + state + self.kept.bytes()
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
        let predicted = self.spec.plan.report().predicted_bytes;
        predicted.saturating_sub(self.shared_bytes())
    }

    fn shared_bytes(&self) -> u64 {
        let own = self.prepared.as_ref().map(|(lease, _)| lease);
        let found = own.or(self.spec.prepared.as_ref());
        found.map_or(0, |lease| lease.value().bytes())
    }

    /// What an increment may have to allocate: all but what is there already.
    pub(super) fn scratch_bytes(&self) -> u64 {
        self.predicted_rest().saturating_sub(self.state_bytes)
    }
}

/// The reservation; whole even if a holder of the lock panicked.
pub(super) fn lock(reservation: &Mutex<Reservation>) -> MutexGuard<'_, Reservation> {
    reservation.lock().unwrap_or_else(PoisonError::into_inner)
}
