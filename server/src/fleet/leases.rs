//! The bucket of leases: taken where nobody has one, renewed by who holds it, given back.

use std::sync::Arc;
use std::time::{Duration, Instant};

use async_nats::jetstream::{self, kv, stream};
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
    /// Whoever has it, if that can be read.
    Held(Option<Holder>),
}

/// The bucket.
pub(super) struct Leases {
    store: kv::Store,
    ttl: Duration,
    pub(super) own: Holder,
}

impl Leases {
    pub(super) async fn open(
        context: &jetstream::Context,
        (ttl, replicas): (Duration, usize),
        own: Holder,
    ) -> Result<Self, async_nats::Error> {
        // As a bucket is made; the call that makes one asks what Debian's NATS cannot tell.
        let config = stream::Config {
            name: format!("KV_{BUCKET}"),
            subjects: vec![format!("$KV.{BUCKET}.>")],
            max_messages_per_subject: 1,
            discard: stream::DiscardPolicy::New,
            allow_rollup: true,
            deny_delete: true,
            // Of all: a server before 2.11 ignores that of a key.
            max_age: ttl,
            duplicate_window: ttl,
            num_replicas: replicas,
            ..Default::default()
        };
        let known = context.get_or_create_stream(config).await?;
        let known = known.cached_info().config.max_age;
        let store = context.get_key_value(BUCKET).await?;
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
        Ok(Asked::Held(entry.and_then(|entry| Holder::read(&entry))))
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
