//! Surfaces of tools in memory, shared by sessions, counted in the byte budget.
//!
//! They are found by their digest. What a session uses is kept; the rest goes, oldest first,
//! where another needs its room or its place; with a data folder it comes back out of it.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use crate::convert::surface::name;
use crate::convert::uploaded::Surface;
use crate::door::access::{Caller, Owners};
use crate::fault::Fault;
use crate::uploads::store::{Account, Reservation, Store};

/// Most surfaces that are kept, in memory and on disk.
pub(crate) const MOST: usize = 1000;

/// One surface.
#[derive(Clone)]
pub(crate) struct Stored {
    pub(crate) surface: Surface,
    pub(crate) created: SystemTime,
}

struct Entry {
    stored: Stored,
    owners: Owners,
    _bytes: Reservation,
}

impl Entry {
    fn is_used(&self) -> bool {
        self.stored.surface.is_shared()
    }
}

/// The surfaces.
#[derive(Default)]
pub(crate) struct Surfaces {
    inner: Mutex<BTreeMap<String, Entry>>,
    /// Whoever holds this changes what is stored, in memory and on disk.
    turn: tokio::sync::Mutex<()>,
}

impl Surfaces {
    /// One change at a time.
    pub(crate) async fn turn(&self) -> tokio::sync::MutexGuard<'_, ()> {
        self.turn.lock().await
    }

    /// A surface by its digest.
    ///
    /// # Errors
    /// `SurfaceNotFound`.
    pub(crate) fn get(&self, digest: &str) -> Result<Stored, Fault> {
        let found = self.lock().get(digest).map(|entry| entry.stored.clone());
        found.ok_or_else(|| Fault::SurfaceNotFound(name(digest)))
    }

    /// As [`Surfaces::get`], and whom it belongs to, if it is in memory.
    pub(crate) fn owned(&self, digest: &str) -> Option<(Stored, Owners)> {
        let inner = self.lock();
        let found = inner.get(digest);
        found.map(|entry| (entry.stored.clone(), entry.owners.clone()))
    }

    /// All surfaces in order of their digests.
    pub(crate) fn all(&self, caller: &Caller) -> Vec<(String, Stored)> {
        let inner = self.lock();
        let one = |(digest, entry): (&String, &Entry)| (digest.clone(), entry.stored.clone());
        let shown = inner.iter().filter(|(_, entry)| entry.owners.admit(caller));
        shown.map(one).collect()
    }

    /// Takes `bytes` out of the budget for a client, for as long as the surface stays, dropping
    /// surfaces that nobody uses.
    ///
    /// # Errors
    /// `MemoryBudget` when even that does not make room, or the client holds too much: then nobody
    /// else's surfaces go for it.
    pub(crate) fn reserve(
        &self,
        store: &Arc<Store>,
        (account, bytes): (Account, u64),
    ) -> Result<Reservation, Fault> {
        store.check(account, bytes)?;
        loop {
            let refused = match store.reserve_for(account, bytes) {
                Ok(reservation) => return Ok(reservation),
                Err(fault) => fault,
            };
            if !self.drop_oldest() {
                return Err(refused);
            }
        }
    }

    /// Says whom a surface belongs to from now on, if it is in memory.
    pub(crate) fn give(&self, digest: &str, owners: Owners) {
        if let Some(entry) = self.lock().get_mut(digest) {
            entry.owners = owners;
        }
    }

    /// Keeps a surface under the bytes reserved for it.
    pub(crate) fn insert(
        &self,
        digest: String,
        (stored, owners): (Stored, Owners),
        mut bytes: Reservation,
    ) -> Stored {
        while self.lock().len() >= MOST && self.drop_oldest() {}
        bytes.force(stored.surface.bytes());
        let mut inner = self.lock();
        let entry = inner.entry(digest).or_insert_with(|| Entry {
            stored,
            owners: Owners::default(),
            _bytes: bytes,
        });
        entry.owners = owners;
        entry.stored.clone()
    }

    /// Drops a surface that no session uses, if it is in memory.
    ///
    /// # Errors
    /// `SurfaceInUse`.
    pub(crate) fn remove(&self, digest: &str) -> Result<(), Fault> {
        let mut inner = self.lock();
        if inner.get(digest).is_some_and(Entry::is_used) {
            return Err(Fault::SurfaceInUse(name(digest)));
        }
        inner.remove(digest);
        Ok(())
    }

    /// Drops the oldest surface that nobody uses; whether there was one.
    fn drop_oldest(&self) -> bool {
        let mut inner = self.lock();
        let unused = inner.iter().filter(|(_, entry)| !entry.is_used());
        let oldest = unused.min_by_key(|(_, entry)| entry.stored.created);
        let digest = oldest.map(|(digest, _)| digest.clone());
        digest.is_some_and(|digest| inner.remove(&digest).is_some())
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Entry>> {
        // No code of others runs under the lock, so a poisoned state is whole.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
