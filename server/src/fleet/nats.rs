//! The fleet of a server: asks for sessions, keeps their leases, stores their records.

use std::collections::HashMap;
use std::hash::{BuildHasher as _, Hasher as _, RandomState};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use bytes::Bytes;
use tokio::runtime::Handle;
use tokio::sync::mpsc;

use super::lease::Lease;
use super::leases::{Asked, Holder, Leases};
use super::stream::{Place, Records, Refused, context, is_unanswered};
use super::{Found, Wish, Wished, nats_addresses, wishes};
use crate::config::Config;
use crate::fault::Fault;
use crate::journal::{Fence, Journal, JournalError};
use crate::watch::metrics::Metrics;

/// Between two tries to store a record.
const PAUSE: Duration = Duration::from_millis(50);
/// Least bytes of records after a whole one before another replaces them.
const LEAST: u64 = 4 << 20;
/// And as many times its bytes.
const TIMES: u64 = 4;
/// Looks at the leases in one time to live.
const LOOKS: u32 = 24;
/// How long a server that starts waits for NATS to answer, which a cluster without a leader does not.
const LEADERLESS: Duration = Duration::from_secs(30);
/// How often a server tries to follow the last record of a session that it takes over.
const TRIES: usize = 5;

/// Other servers, by way of NATS.
pub(crate) struct Fleet {
    client: async_nats::Client,
    leases: Arc<Leases>,
    records: Records,
    ttl: Duration,
    /// By name of the session.
    held: Mutex<HashMap<String, Arc<Lease>>>,
    runtime: Handle,
    metrics: Arc<Metrics>,
    journal: Arc<Journal>,
}

impl Fleet {
    /// Joins the fleet of the settings, if they name one. The sessions of the data folder go:
    /// the fleet knows better.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(crate) async fn join(
        config: &Config,
        url: &str,
        journal: Option<&Arc<Journal>>,
        metrics: &Arc<Metrics>,
    ) -> Result<Option<Arc<Self>>, String> {
        let Some(journal) = journal.filter(|_| !config.fleet_nats.is_empty()) else {
            return Ok(None);
        };
        let joined = Self::open_patiently(config, url, journal, metrics).await;
        let fleet = joined.map_err(|error| format!("{}: {error}", config.fleet_nats))?;
        journal
            .forget_sessions()
            .await
            .map_err(|error| error.to_string())?;
        let fleet = Arc::new(fleet);
        metrics.fleet_joined();
        journal.fence(Arc::clone(&fleet) as Arc<dyn Fence>);
        Ok(Some(fleet))
    }

    async fn open_patiently(
        config: &Config,
        url: &str,
        journal: &Arc<Journal>,
        metrics: &Arc<Metrics>,
    ) -> Result<Self, async_nats::Error> {
        let until = Instant::now() + LEADERLESS;
        loop {
            match Self::open(config, url, journal, metrics).await {
                Err(error) if is_unanswered(&error) && Instant::now() < until => {
                    tracing::info!(why = error.to_string(), "the fleet is asked again");
                    tokio::time::sleep(PAUSE).await;
                }
                opened => return opened,
            }
        }
    }

    async fn open(
        config: &Config,
        url: &str,
        journal: &Arc<Journal>,
        metrics: &Arc<Metrics>,
    ) -> Result<Self, async_nats::Error> {
        let ttl = Duration::from_secs(config.fleet_lease_seconds);
        let replicas = config.fleet_replicas;
        let server = match config.fleet_name.as_str() {
            "" => url.to_owned(),
            name => name.to_owned(),
        };
        let addresses = nats_addresses(&config.fleet_nats);
        let client = async_nats::connect(addresses.as_slice()).await?;
        let context = context(client.clone(), ttl);
        let own = Holder {
            // Random keys of the standard hasher.
            process: format!("{:016x}", RandomState::new().build_hasher().finish()),
            server: server.clone(),
            epoch: 0,
        };
        let store = Path::new(&config.fleet_store);
        Ok(Self {
            client,
            leases: Arc::new(Leases::open(&context, (ttl, replicas), own).await?),
            records: Records::open(&context, replicas, (store, &server)).await?,
            ttl,
            held: Mutex::default(),
            runtime: Handle::current(),
            metrics: Arc::clone(metrics),
            journal: Arc::clone(journal),
        })
    }

    /// Takes a session that no server holds, or whose holder gives it away.
    ///
    /// # Errors
    /// `SessionElsewhere` with its holder; `Unwritable` where NATS does not answer.
    pub(crate) async fn ask(&self, name: &str, wish: Wish) -> Result<Found, Fault> {
        let away = |error: async_nats::Error| Fault::Unwritable(format!("the fleet: {error}"));
        let lease = match self.lease_of(name, wish).await.map_err(away)? {
            Asked::Taken(lease) => lease,
            Asked::Held(holder) => {
                let owner = holder.map_or_else(String::new, |holder| holder.server);
                let name = name.to_owned();
                return Err(Fault::SessionElsewhere { name, owner });
            }
        };
        self.enter(name, &lease);
        let taken = self.take_over(name, &lease).await;
        if taken.is_err() {
            self.release(name);
        }
        taken.map_err(away)
    }

    /// The lease of a session, from its holder where that gives it back.
    async fn lease_of(&self, name: &str, wish: Wish) -> Result<Asked, async_nats::Error> {
        let asked = self.leases.ask(id(name)).await?;
        let (Asked::Held(Some(holder)), Wish::Drive) = (&asked, wish) else {
            return Ok(asked);
        };
        let is_other = holder.process != self.leases.own.process;
        let patience = self.ttl / 6;
        let whom = (&self.client, holder.process.as_str());
        if is_other && wishes::ask(whom, id(name), patience).await {
            // Given back a moment after the answer.
            tokio::time::sleep(PAUSE).await;
            return self.leases.ask(id(name)).await;
        }
        Ok(asked)
    }

    /// The wishes of other servers for sessions of this one.
    pub(crate) async fn wishes(&self) -> Option<mpsc::Receiver<Wished>> {
        let wishes = wishes::of_others(&self.client, &self.leases.own.process).await;
        let wishes = wishes.inspect_err(|error| {
            tracing::warn!(
                why = error.to_string(),
                "wishes of other servers are not heard"
            );
        });
        wishes.ok()
    }

    /// Ends what the holder before may still write, then reads what it wrote.
    async fn take_over(&self, name: &str, lease: &Lease) -> Result<Found, async_nats::Error> {
        let mut tries = 0;
        let last = loop {
            let Some(newest) = self.records.newest(id(name)).await? else {
                return Ok(Found::New);
            };
            match self
                .records
                .publish(&place(name, lease, newest), &Bytes::new())
                .await
            {
                Ok(own) => {
                    lease.tail.store(own, Ordering::Release);
                    break own;
                }
                // The holder before came first, once more.
                Err(Refused::Fenced) if tries < TRIES => tries += 1,
                Err(Refused::Fenced) => return Err("another server writes".into()),
                Err(Refused::Unknown(why)) => return Err(why.into()),
            }
        };
        let read = self.records.read(id(name), last).await?;
        let bytes = read.iter().map(|changes| changes.len() as u64).sum();
        lease.bytes.store(bytes, Ordering::Release);
        if !self.journal.adopt(name, &read).await? {
            return Ok(Found::New);
        }
        self.metrics.fleet_taken();
        tracing::info!(
            name,
            epoch = lease.epoch,
            records = read.len(),
            "session taken over"
        );
        Ok(Found::Taken)
    }

    /// What says that a session is this server's.
    pub(crate) fn lease(&self, name: &str) -> Option<Arc<Lease>> {
        self.lock().get(name).cloned()
    }

    /// Gives a session back that this server has no more of.
    pub(crate) fn release(&self, name: &str) {
        let Some(lease) = self.lock().remove(name) else {
            return;
        };
        self.metrics.fleet_held(self.lock().len());
        if !lease.holds() {
            return;
        }
        let (leases, id) = (Arc::clone(&self.leases), id(name).to_owned());
        self.runtime.spawn(async move {
            // One that is not given back ends by itself.
            if let Err(error) = leases.release(&id, &lease).await {
                tracing::debug!(why = error.to_string(), "a lease is not given back");
            }
        });
    }

    /// Renews what is held until it is dropped; `lost` gets the sessions that are this server's no
    /// more.
    pub(crate) async fn keep(&self, lost: impl Fn(&str)) {
        let mut looks = tokio::time::interval(self.ttl / LOOKS);
        looks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        loop {
            looks.tick().await;
            let held: Vec<_> = {
                let held = self.lock();
                held.iter()
                    .map(|(name, lease)| (name.clone(), Arc::clone(lease)))
                    .collect()
            };
            for (name, lease) in &held {
                if !lease.holds() {
                    self.metrics.fleet_silent(lease.age());
                    self.lock().remove(name);
                    lost(name);
                } else if lease.is_due() {
                    self.renew(name, lease);
                }
            }
            self.metrics.fleet_held(self.lock().len());
        }
    }

    /// Renews one in the background: a call that hangs holds up no other.
    fn renew(&self, name: &str, lease: &Arc<Lease>) {
        let (leases, lease) = (Arc::clone(&self.leases), Arc::clone(lease));
        let (id, metrics) = (id(name).to_owned(), Arc::clone(&self.metrics));
        self.runtime.spawn(async move {
            match leases.renew(&id, &lease).await {
                Ok(true) => metrics.fleet_renewed(),
                Ok(false) => lease.lose(),
                Err(error) => tracing::debug!(why = error.to_string(), "a lease is not renewed"),
            }
        });
    }

    fn enter(&self, name: &str, lease: &Arc<Lease>) {
        self.lock().insert(name.to_owned(), Arc::clone(lease));
        self.metrics.fleet_held(self.lock().len());
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<String, Arc<Lease>>> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Stores a record after the last one, as long as the lease holds.
    async fn store_one(&self, name: &str, changes: &Bytes) -> Result<(), JournalError> {
        let refused = || JournalError::Elsewhere(name.to_owned());
        let lease = self.lease(name).ok_or_else(refused)?;
        let place = place(name, &lease, lease.tail.load(Ordering::Acquire));
        while lease.holds() {
            match self.records.publish(&place, changes).await {
                Ok(own) => {
                    lease.tail.store(own, Ordering::Release);
                    add(&lease.bytes, changes.len());
                    return Ok(());
                }
                Err(Refused::Fenced) => {
                    self.metrics.fleet_fenced();
                    lease.lose();
                }
                Err(Refused::Unknown(why)) => {
                    tracing::debug!(why, "a record is sent again");
                    tokio::time::sleep(PAUSE).await;
                }
            }
        }
        Err(refused())
    }

    /// Stores a record that makes those before it needless, and drops them.
    async fn store_whole(&self, name: &str, changes: &Bytes) -> Result<(), async_nats::Error> {
        let stored = self.store_one(name, changes).await;
        stored.map_err(|error| error.to_string())?;
        let Some(lease) = self.lease(name) else {
            return Ok(());
        };
        lease.bytes.store(0, Ordering::Release);
        lease.whole.store(changes.len() as u64, Ordering::Release);
        let (own, number) = (
            lease.tail.load(Ordering::Acquire),
            lease.records.load(Ordering::Acquire),
        );
        let place = Place {
            id: id(name),
            epoch: lease.epoch,
            after: 0,
            number,
        };
        // The last record says that there is no session: it goes too.
        let first = own + u64::from(changes.is_empty());
        self.records.drop_before(&place, first).await
    }
}

impl Fence for Fleet {
    fn store(&self, records: &[(&str, Bytes)]) -> Vec<Result<(), JournalError>> {
        let sent = records.iter();
        let sent = sent.map(|(name, changes)| self.store_one(name, changes));
        self.runtime.block_on(futures_util::future::join_all(sent))
    }

    fn is_whole_due(&self, name: &str) -> bool {
        let lease = self.lease(name);
        lease.is_some_and(|lease| {
            let whole = lease.whole.load(Ordering::Acquire);
            lease.bytes.load(Ordering::Acquire) > LEAST.max(TIMES * whole)
        })
    }

    fn replace(&self, name: &str, whole: &Bytes) {
        let replaced = self.runtime.block_on(self.store_whole(name, whole));
        if let Err(error) = replaced {
            tracing::warn!(
                name,
                why = error.to_string(),
                "earlier records stay in the stream"
            );
        }
    }
}

/// After that record, with the next number of this holder.
fn place<'a>(name: &'a str, lease: &Lease, after: u64) -> Place<'a> {
    Place {
        id: id(name),
        epoch: lease.epoch,
        after,
        number: lease.records.fetch_add(1, Ordering::AcqRel) + 1,
    }
}

fn add(count: &AtomicU64, bytes: usize) {
    count.fetch_add(bytes as u64, Ordering::AcqRel);
}

fn id(name: &str) -> &str {
    name.strip_prefix("sessions/").unwrap_or(name)
}
