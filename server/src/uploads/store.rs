//! Meshes and prepared data in memory, shared by sessions, under one byte budget.
//!
//! Meshes are found by their digest, prepared data by the key of their plan.
//! What a session uses is never dropped; the rest goes least recently used
//! first when something needs room. Sessions and uploads hold [`Reservation`]s
//! in the same budget, taken before they allocate.

mod contents;
mod owned;
mod reservation;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use signorini::mesh::{Mesh, MeshId};
use signorini::plan::PreparedKey;
use signorini::prepare::Prepared;

use crate::convert::mesh::{MeshUse, name};
use crate::door::access::{Caller, Owners};
use crate::fault::Fault;
use crate::watch::metrics::{Kind, Metrics};
pub(crate) use contents::Lease;
use contents::{Contents, PreparedEntry, entry, uses};
pub(crate) use reservation::{Account, Reservation};

/// How much a store holds, counts and bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Held {
    pub(crate) meshes: usize,
    pub(crate) mesh_bytes: u64,
    /// Prepared bodies, shared by sessions on the same scene.
    pub(crate) prepared: usize,
    pub(crate) prepared_bytes: u64,
    /// Of sessions and uploads.
    pub(crate) session_bytes: u64,
}

/// The store.
pub(crate) struct Store {
    inner: Mutex<Contents>,
    budget: u64,
    metrics: Arc<Metrics>,
}

impl Store {
    /// An empty store that may hold `budget` bytes.
    pub(crate) fn new(budget: u64, metrics: &Arc<Metrics>) -> Arc<Self> {
        metrics.memory_budget(budget);
        let store = Self {
            inner: Mutex::default(),
            budget,
            metrics: Arc::clone(metrics),
        };
        store.report(&store.lock());
        Arc::new(store)
    }

    /// How much is held just now.
    pub(crate) fn held(&self) -> Held {
        let inner = self.lock();
        Held {
            meshes: inner.meshes.len(),
            mesh_bytes: inner.mesh_bytes(),
            prepared: inner.prepared.len(),
            prepared_bytes: inner.prepared_bytes(),
            session_bytes: inner.reserved,
        }
    }

    /// Bytes that may be held.
    pub(crate) fn budget(&self) -> u64 {
        self.budget
    }

    /// A mesh by its identity.
    pub(crate) fn mesh(&self, id: MeshId) -> Result<Lease<Mesh>, Fault> {
        let mut inner = self.lock();
        let tick = inner.next_tick();
        let found = inner.meshes.get_mut(&id).map(|entry| entry.lease(tick));
        self.count(Kind::Mesh, found.as_ref());
        found.ok_or_else(|| Fault::MeshNotFound(name(id)))
    }

    /// Keeps a mesh.
    pub(crate) fn insert_mesh(&self, mesh: Mesh, owners: Owners) -> Lease<Mesh> {
        let mut inner = self.lock();
        let tick = inner.next_tick();
        let bytes = mesh.bytes();
        inner.owners.entry(mesh.id()).or_insert(owners);
        let entry = inner
            .meshes
            .entry(mesh.id())
            .or_insert_with(|| entry(Arc::new(mesh), bytes));
        let lease = entry.lease(tick);
        self.report(&inner);
        lease
    }

    /// When a mesh came and was used.
    pub(crate) fn mesh_use(&self, id: MeshId) -> Result<MeshUse, Fault> {
        let inner = self.lock();
        let entry = inner
            .meshes
            .get(&id)
            .ok_or_else(|| Fault::MeshNotFound(name(id)))?;
        Ok(uses(entry))
    }

    /// Up to `count` meshes after `after`, in order of their identities.
    pub(crate) fn meshes(
        &self,
        caller: &Caller,
        after: Option<MeshId>,
        count: usize,
    ) -> Vec<(Arc<Mesh>, MeshUse)> {
        let inner = self.lock();
        let admits = |id: &MeshId| inner.owners.get(id).is_none_or(|one| one.admit(caller));
        let is_shown = |id: &MeshId| after.is_none_or(|after| *id > after) && admits(id);
        let later = inner.meshes.iter().filter(|(id, _)| is_shown(id));
        later
            .take(count)
            .map(|(_, entry)| (Arc::clone(&entry.value), uses(entry)))
            .collect()
    }

    /// Drops a mesh that no session uses.
    pub(crate) fn delete_mesh(&self, id: MeshId) -> Result<(), Fault> {
        let mut inner = self.lock();
        let entry = inner
            .meshes
            .get(&id)
            .ok_or_else(|| Fault::MeshNotFound(name(id)))?;
        let sessions = entry.sessions();
        if sessions > 0 {
            let name = name(id);
            return Err(Fault::MeshInUse { name, sessions });
        }
        inner.remove_mesh(id);
        self.report(&inner);
        Ok(())
    }

    /// Prepared data by their key.
    pub(crate) fn prepared(&self, key: &PreparedKey) -> Option<Lease<Prepared>> {
        let mut inner = self.lock();
        let tick = inner.next_tick();
        let found = inner.prepared.get_mut(key).map(|one| one.entry.lease(tick));
        self.count(Kind::Prepared, found.as_ref());
        found
    }

    /// Keeps prepared data that are there already from being dropped; no use of
    /// the cache yet.
    pub(crate) fn hold_prepared(&self, key: &PreparedKey) -> Option<Lease<Prepared>> {
        let mut inner = self.lock();
        let tick = inner.next_tick();
        inner.prepared.get_mut(key).map(|one| one.entry.lease(tick))
    }

    /// Keeps prepared data.
    pub(crate) fn insert_prepared(
        &self,
        key: PreparedKey,
        mesh: MeshId,
        prepared: Prepared,
    ) -> Lease<Prepared> {
        let mut inner = self.lock();
        let tick = inner.next_tick();
        let bytes = prepared.bytes();
        let one = inner.prepared.entry(key).or_insert_with(|| PreparedEntry {
            mesh,
            entry: entry(Arc::new(prepared), bytes),
        });
        let lease = one.entry.lease(tick);
        self.report(&inner);
        lease
    }

    /// Whoever holds this may build the data of `key`; others wait and find them.
    pub(crate) fn turn(&self, key: PreparedKey) -> Arc<tokio::sync::Mutex<()>> {
        let mut inner = self.lock();
        inner.turns.retain(|_, turn| Arc::strong_count(turn) > 1);
        Arc::clone(inner.turns.entry(key).or_default())
    }

    /// Takes `bytes` out of the budget, dropping what nobody uses.
    ///
    /// # Errors
    /// `MemoryBudget` when even that does not make room.
    pub(crate) fn reserve(self: &Arc<Self>, bytes: u64) -> Result<Reservation, Fault> {
        self.reserve_as(None, bytes)
    }

    /// As [`Store::reserve`], counted for a client as long as it is held.
    ///
    /// # Errors
    /// `MemoryBudget` also when that client holds too much.
    pub(crate) fn reserve_for(
        self: &Arc<Self>,
        account: Account,
        bytes: u64,
    ) -> Result<Reservation, Fault> {
        self.reserve_as(Some(account), bytes)
    }

    /// Whether a client may hold so much more, room or not.
    ///
    /// # Errors
    /// `MemoryBudget` when that client holds too much.
    pub(crate) fn check(&self, account: Account, bytes: u64) -> Result<(), Fault> {
        self.lock().check(account, bytes)
    }

    fn reserve_as(
        self: &Arc<Self>,
        account: Option<Account>,
        bytes: u64,
    ) -> Result<Reservation, Fault> {
        let mut inner = self.lock();
        if let Some(account) = account {
            inner.check(account, bytes)?;
        }
        self.make_room(&mut inner, bytes)?;
        let client = account.map(|account| account.client);
        inner.settle(client, 0, bytes);
        self.report(&inner);
        Ok(Reservation::new(self, client, bytes))
    }

    fn make_room(&self, inner: &mut Contents, bytes: u64) -> Result<(), Fault> {
        let held = inner.in_use();
        if held.saturating_add(bytes) > self.budget {
            return Err(Fault::MemoryBudget {
                predicted: bytes,
                held,
                budget: self.budget,
            });
        }
        while inner.held().saturating_add(bytes) > self.budget {
            let evicted = match (inner.oldest_prepared(), inner.oldest_mesh()) {
                (Some((tick, key)), mesh) if mesh.is_none_or(|(other, _)| tick < other) => {
                    inner.prepared.remove(&key);
                    Kind::Prepared
                }
                (_, Some((_, id))) => {
                    inner.remove_mesh(id);
                    Kind::Mesh
                }
                // All that is left is in use, and that fits.
                (_, None) => break,
            };
            self.metrics.evicted(evicted);
        }
        Ok(())
    }

    /// Changes a reservation, making room; fails with the bytes that are lacking.
    fn grow(&self, held: &Reservation, after: u64) -> Result<(), u64> {
        let before = held.bytes();
        let mut inner = self.lock();
        let more = after.saturating_sub(before);
        if self.make_room(&mut inner, more).is_err() {
            return Err(inner.in_use().saturating_add(more) - self.budget);
        }
        inner.settle(held.client(), before, after);
        self.report(&inner);
        Ok(())
    }

    fn change_reservation(&self, held: &Reservation, after: u64) {
        let mut inner = self.lock();
        inner.settle(held.client(), held.bytes(), after);
        self.report(&inner);
    }

    fn count<T>(&self, kind: Kind, found: Option<&T>) {
        match found {
            Some(_) => self.metrics.cache_hit(kind),
            None => self.metrics.cache_miss(kind),
        }
    }

    fn report(&self, inner: &Contents) {
        self.metrics.store(inner.meshes.len(), inner.prepared.len());
        self.metrics.memory(Kind::Mesh, inner.mesh_bytes());
        self.metrics.memory(Kind::Prepared, inner.prepared_bytes());
        self.metrics.memory(Kind::Session, inner.reserved);
    }

    fn lock(&self) -> MutexGuard<'_, Contents> {
        // No code of others runs under the lock, so a poisoned state is whole.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests;
