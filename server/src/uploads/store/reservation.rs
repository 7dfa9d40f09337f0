//! Bytes of the budget that somebody holds.

use std::sync::Arc;

use super::Store;
use crate::door::client_key::ClientIdentity;
use crate::fault::Fault;

/// For whom bytes are counted, and how many that one may hold.
#[derive(Clone, Copy)]
pub(crate) struct Account {
    pub(crate) client: ClientIdentity,
    pub(crate) most: u64,
}

/// Bytes taken out of the budget; given back on drop.
pub(crate) struct Reservation {
    store: Arc<Store>,
    client: Option<ClientIdentity>,
    bytes: u64,
}

impl Reservation {
    pub(super) fn new(store: &Arc<Store>, client: Option<ClientIdentity>, bytes: u64) -> Self {
        Self {
            store: Arc::clone(store),
            client,
            bytes,
        }
    }

    pub(super) fn client(&self) -> Option<ClientIdentity> {
        self.client
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Replaces the prediction by what is really held, dropping what nobody uses
    /// where that takes more.
    ///
    /// # Errors
    /// The bytes for which there is no room; the reservation is then as before.
    pub(crate) fn resize(&mut self, bytes: u64) -> Result<(), u64> {
        self.store.grow(self, bytes)?;
        self.bytes = bytes;
        Ok(())
    }

    /// As [`Reservation::resize`], with the fault for a request.
    ///
    /// # Errors
    /// `MemoryBudget`; the reservation is then as before.
    pub(crate) fn claim(&mut self, bytes: u64) -> Result<(), Fault> {
        let held = |lacking: u64| Fault::MemoryBudget {
            predicted: bytes,
            held: (self.store.budget + lacking).saturating_sub(bytes),
            budget: self.store.budget,
        };
        self.store.grow(self, bytes).map_err(held)?;
        self.bytes = bytes;
        Ok(())
    }

    /// Counts what is really held, whether there is room or not.
    pub(crate) fn force(&mut self, bytes: u64) {
        self.store.change_reservation(self, bytes);
        self.bytes = bytes;
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        self.store.change_reservation(self, 0);
    }
}
