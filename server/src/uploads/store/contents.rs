//! What the store holds, and what of it may go.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::SystemTime;

use signorini::mesh::{Mesh, MeshId};
use signorini::plan::PreparedKey;
use signorini::prepare::Prepared;

use super::reservation::Account;
use crate::convert::mesh::MeshUse;
use crate::door::access::Owners;
use crate::door::client_key::ClientIdentity;
use crate::fault::Fault;

/// Marks an entry as used as long as it lives.
type Use = Arc<()>;

pub(super) struct Entry<T> {
    pub(super) value: Arc<T>,
    pub(super) bytes: u64,
    pub(super) uses: Use,
    pub(super) created: SystemTime,
    pub(super) used: SystemTime,
    /// Orders uses; larger is later.
    tick: u64,
}

impl<T> Entry<T> {
    pub(super) fn sessions(&self) -> usize {
        Arc::strong_count(&self.uses) - 1
    }

    pub(super) fn lease(&mut self, tick: u64) -> Lease<T> {
        self.tick = tick;
        self.used = SystemTime::now();
        Lease {
            value: Arc::clone(&self.value),
            _use: Arc::clone(&self.uses),
        }
    }
}

/// A stored value that cannot be dropped meanwhile.
pub(crate) struct Lease<T> {
    value: Arc<T>,
    _use: Use,
}

impl<T> Lease<T> {
    pub(crate) fn value(&self) -> &Arc<T> {
        &self.value
    }
}

impl<T> AsRef<T> for Lease<T> {
    fn as_ref(&self) -> &T {
        &self.value
    }
}

pub(super) struct PreparedEntry {
    pub(super) mesh: MeshId,
    pub(super) entry: Entry<Prepared>,
}

/// What the store holds.
#[derive(Default)]
pub(super) struct Contents {
    pub(super) meshes: BTreeMap<MeshId, Entry<Mesh>>,
    /// Of each of them.
    pub(super) owners: HashMap<MeshId, Owners>,
    pub(super) prepared: HashMap<PreparedKey, PreparedEntry>,
    pub(super) turns: HashMap<PreparedKey, Arc<tokio::sync::Mutex<()>>>,
    pub(super) reserved: u64,
    /// Of that, what is counted for clients.
    pub(super) accounts: HashMap<ClientIdentity, u64>,
    tick: u64,
}

impl Contents {
    pub(super) fn mesh_bytes(&self) -> u64 {
        self.meshes.values().map(|entry| entry.bytes).sum()
    }

    pub(super) fn prepared_bytes(&self) -> u64 {
        self.prepared.values().map(|entry| entry.entry.bytes).sum()
    }

    pub(super) fn held(&self) -> u64 {
        self.mesh_bytes() + self.prepared_bytes() + self.reserved
    }

    /// Bytes that no eviction frees.
    pub(super) fn in_use(&self) -> u64 {
        let meshes = self.meshes.values().filter(|one| one.sessions() > 0);
        let prepared = self.prepared.values().map(|one| &one.entry);
        let prepared = prepared.filter(|one| one.sessions() > 0);
        let meshes: u64 = meshes.map(|one| one.bytes).sum();
        let prepared: u64 = prepared.map(|one| one.bytes).sum();
        meshes + prepared + self.reserved
    }

    /// A reservation has changed; its client's account, if any, with it.
    pub(super) fn settle(&mut self, client: Option<ClientIdentity>, before: u64, after: u64) {
        let changed = |bytes: u64| bytes.saturating_sub(before).saturating_add(after);
        self.reserved = changed(self.reserved);
        let Some(client) = client else { return };
        let held = changed(self.of_client(client));
        match held {
            0 => drop(self.accounts.remove(&client)),
            held => drop(self.accounts.insert(client, held)),
        }
    }

    pub(super) fn of_client(&self, client: ClientIdentity) -> u64 {
        self.accounts.get(&client).copied().unwrap_or(0)
    }

    pub(super) fn check(&self, account: Account, bytes: u64) -> Result<(), Fault> {
        let held = self.of_client(account.client);
        if held.saturating_add(bytes) > account.most {
            Err(Fault::MemoryBudget {
                predicted: bytes,
                held,
                budget: account.most,
            })
        } else {
            Ok(())
        }
    }

    pub(super) fn next_tick(&mut self) -> u64 {
        self.tick += 1;
        self.tick
    }

    pub(super) fn oldest_prepared(&self) -> Option<(u64, PreparedKey)> {
        let unused = self
            .prepared
            .iter()
            .filter(|(_, one)| one.entry.sessions() == 0);
        unused.map(|(key, one)| (one.entry.tick, *key)).min()
    }

    pub(super) fn oldest_mesh(&self) -> Option<(u64, MeshId)> {
        let unused = self
            .meshes
            .iter()
            .filter(|(_, entry)| entry.sessions() == 0);
        unused.map(|(id, entry)| (entry.tick, *id)).min()
    }

    pub(super) fn remove_mesh(&mut self, id: MeshId) {
        self.meshes.remove(&id);
        self.owners.remove(&id);
        // Prepared data of a mesh are of no use without it.
        self.prepared.retain(|_, one| one.mesh != id);
    }
}

pub(super) fn entry<T>(value: Arc<T>, bytes: u64) -> Entry<T> {
    let now = SystemTime::now();
    Entry {
        value,
        bytes,
        uses: Use::default(),
        created: now,
        used: now,
        tick: 0,
    }
}

pub(super) fn uses(entry: &Entry<Mesh>) -> MeshUse {
    MeshUse {
        sessions: entry.sessions(),
        created: entry.created,
        used: entry.used,
    }
}
