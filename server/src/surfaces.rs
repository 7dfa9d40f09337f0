//! Surfaces of tools in memory, shared by sessions, counted in the byte budget.
//!
//! They are found by their digest. What a session uses is kept; the rest goes, oldest first,
//! where another needs its room or its place.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use crate::access::{Caller, Owners};
use crate::convert::surface::name;
use crate::convert::uploaded::Surface;
use crate::fault::Fault;
use crate::store::{Account, Reservation, Store};

/// Most surfaces that are kept.
const MOST: usize = 1000;

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
pub(crate) struct Surfaces(Mutex<BTreeMap<String, Entry>>);

impl Surfaces {
    /// A surface by its digest.
    ///
    /// # Errors
    /// `SurfaceNotFound`.
    pub(crate) fn get(&self, digest: &str) -> Result<Stored, Fault> {
        let found = self.lock().get(digest).map(|entry| entry.stored.clone());
        found.ok_or_else(|| Fault::SurfaceNotFound(name(digest)))
    }

    /// The surface of that digest, if it is there for `caller`.
    ///
    /// # Errors
    /// `SurfaceNotFound`.
    pub(crate) fn get_for(&self, caller: &Caller, digest: &str) -> Result<Stored, Fault> {
        let inner = self.lock();
        let found = inner.get(digest).filter(|entry| entry.owners.admit(caller));
        let found = found.map(|entry| entry.stored.clone());
        found.ok_or_else(|| Fault::SurfaceNotFound(name(digest)))
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

    /// Keeps a surface under the bytes reserved for its upload.
    pub(crate) fn insert(
        &self,
        caller: &Caller,
        digest: String,
        surface: Surface,
        mut bytes: Reservation,
    ) -> Stored {
        while self.lock().len() >= MOST && self.drop_oldest() {}
        bytes.force(surface.bytes());
        let mut inner = self.lock();
        let entry = inner.entry(digest).or_insert_with(|| Entry {
            stored: Stored {
                surface,
                created: SystemTime::now(),
            },
            owners: Owners::of(caller),
            _bytes: bytes,
        });
        // Nothing new for one whose it is.
        let _new = entry.owners.join(caller);
        entry.stored.clone()
    }

    /// Drops a surface that no session uses.
    ///
    /// # Errors
    /// `SurfaceNotFound`, `SurfaceInUse`.
    pub(crate) fn delete(&self, caller: &Caller, digest: &str) -> Result<(), Fault> {
        let mut inner = self.lock();
        let found = inner.get_mut(digest);
        let Some(entry) = found.filter(|entry| entry.owners.admit(caller)) else {
            return Err(Fault::SurfaceNotFound(name(digest)));
        };
        // Where others have sent it too, it stays for them.
        if entry.owners.leave(caller) {
            return Ok(());
        }
        if entry.is_used() {
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
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
