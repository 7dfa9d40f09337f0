//! The bucket of leases: taken where nobody has one, renewed by who holds it, given back.

use std::sync::Arc;
use std::time::{Duration, Instant};

use async_nats::jetstream::{self, kv};
use bytes::Bytes;

use super::lease::Lease;

pub(super) const BUCKET: &str = "signorini-leases";

/// What the entry of a session says.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(super) struct Holder {
    /// Of the process: another one of the same address has another.
    pub(super) process: String,
    /// Where it is found, for people.
    pub(super) server: String,
    /// Revision at which it was taken; 0 until the first renewal.
    #[serde(default)]
    pub(super) epoch: u64,
}

impl Holder {
    pub(super) fn read(entry: &[u8]) -> Option<Self> {
        serde_json::from_slice(entry).ok()
    }

    fn written(&self) -> Bytes {
        // A struct of texts and a number is always written.
        serde_json::to_vec(self).unwrap_or_default().into()
    }
}

/// The answer to a question for a lease.
pub(super) enum Asked {
    Taken(Arc<Lease>),
    /// Whoever has it.
    Held(String),
}

/// The bucket.
pub(super) struct Leases {
    store: kv::Store,
    ttl: Duration,
    own: Holder,
}

impl Leases {
    pub(super) async fn open(
        context: &jetstream::Context,
        (ttl, replicas): (Duration, usize),
        own: Holder,
    ) -> Result<Self, async_nats::Error> {
        let config = kv::Config {
            bucket: BUCKET.to_owned(),
            history: 1,
            // Of the bucket: a server before 2.11 ignores that of a key.
            max_age: ttl,
            num_replicas: replicas,
            ..Default::default()
        };
        let store = context.create_key_value(config).await?;
        let known = store.status().await?.max_age();
        if known != ttl {
            let known = known.as_secs();
            return Err(format!(
                "the leases of this fleet live {known} s: `fleet_lease_seconds` must say the same"
            )
            .into());
        }
        Ok(Self { store, ttl, own })
    }

    /// Takes the lease of a session that nobody holds.
    pub(super) async fn ask(&self, id: &str) -> Result<Asked, async_nats::Error> {
        let asked = Instant::now();
        match self.store.create(id, self.own.written()).await {
            Ok(revision) => {
                let lease = Lease::new(revision, self.ttl, asked);
                return Ok(Asked::Taken(Arc::new(lease)));
            }
            Err(error) if error.kind() == kv::CreateErrorKind::AlreadyExists => {}
            Err(error) => return Err(error.into()),
        }
        let entry = self.store.get(id).await?;
        let holder = entry.and_then(|entry| Holder::read(&entry));
        Ok(Asked::Held(
            holder.map_or_else(String::new, |holder| holder.server),
        ))
    }

    /// Renews a lease; whether it was this server's still.
    pub(super) async fn renew(&self, id: &str, lease: &Lease) -> Result<bool, async_nats::Error> {
        let asked = Instant::now();
        let own = Holder {
            epoch: lease.epoch,
            ..self.own.clone()
        };
        let renewed = self.store.update(id, own.written(), lease.revision()).await;
        let error = match renewed {
            Ok(revision) => {
                lease.renewed(revision, asked);
                return Ok(true);
            }
            Err(error) => error,
        };
        if error.kind() != kv::UpdateErrorKind::WrongLastRevision {
            return Err(error.into());
        }
        // The answer to an earlier renewal may have been lost.
        let entry = self.store.entry(id).await?;
        let found = entry.filter(|entry| Holder::read(&entry.value) == Some(own));
        if let Some(entry) = &found {
            lease.follow(entry.revision);
        }
        Ok(found.is_some())
    }

    /// Gives a lease back.
    pub(super) async fn release(&self, id: &str, lease: &Lease) -> Result<(), async_nats::Error> {
        let revision = Some(lease.revision());
        Ok(self.store.delete_expect_revision(id, revision).await?)
    }
}
