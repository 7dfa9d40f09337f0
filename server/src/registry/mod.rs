//! The sessions of a server, by name: found, made, woken, and let go.
//!
//! | file | what it does |
//! |---|---|
//! | `directory` | names and the sessions awake |
//! | `claim`, `names` | a name until its session exists |
//! | `asking` | sessions that other servers of a fleet hold |
//! | `planning` | from a scene to mesh, tools, plan and memory of a session |
//! | `refining` | meshes that are refined until goals are known well enough |
//! | `wake` | a session out of the data folder |

mod asking;
mod claim;
mod directory;
mod names;
pub(crate) mod planning;
pub(crate) mod refining;
mod wake;

use std::collections::HashSet;
use std::pin::pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use signorini_proto::v1 as wire;
use tokio::sync::{Notify, watch};

use crate::door::access::Caller;
use crate::door::client_key::ClientIdentity;
use crate::door::refusal;
use crate::fault::Fault;
use crate::fleet::Wish;
use crate::journal::{Change, JournalError, Listed};
use crate::session::{Handle, Services, SessionEnd};
use crate::watch::metrics::Metrics;
use claim::Waking;
pub(crate) use claim::{Claim, Claimed};
use directory::{Directory, Sleeper};
use names::{checked_name, new_name};

/// Names of expired sessions that are remembered, to say so.
const REMEMBERED: usize = 1000;
/// Bytes of a name in a request.
const LONGEST_NAME: usize = 256;

/// How streams are kept alive, and when they end.
#[derive(Clone, Copy)]
pub(crate) struct Pace {
    /// Without another message until a heartbeat.
    pub(crate) heartbeat: Duration,
    /// Without a message taken until the end.
    pub(crate) unread: Duration,
}

/// Where a session is.
enum Found {
    Awake(Handle),
    /// The caller wakes it.
    Asleep(Waking),
    /// Another call wakes it.
    Waking,
}

/// All sessions.
pub(crate) struct Registry {
    directory: Mutex<Directory>,
    draining: AtomicBool,
    /// Nobody can ask any more.
    closed: AtomicBool,
    /// Sessions that the fleet is asked for just now.
    asked: Mutex<HashSet<String>>,
    /// Some session started or will not start.
    settled: Notify,
    streams: watch::Sender<usize>,
    services: Arc<Services>,
}

impl Registry {
    /// All sessions that the data folder has.
    ///
    /// # Errors
    /// [`JournalError`] when it cannot be read.
    pub(crate) fn new(services: &Arc<Services>) -> Result<Arc<Self>, JournalError> {
        let mut directory = Directory::default();
        let stored = services.journal.as_ref().map(|journal| journal.sessions());
        for (name, listed) in stored.transpose()?.unwrap_or_default() {
            directory.enter(name, &listed, &services.config);
        }
        services.metrics.asleep(directory.asleep.len());
        Ok(Arc::new(Self {
            directory: Mutex::new(directory),
            draining: AtomicBool::new(false),
            closed: AtomicBool::new(false),
            asked: Mutex::default(),
            settled: Notify::new(),
            streams: watch::Sender::new(0),
            services: Arc::clone(services),
        }))
    }

    /// Counts a refused request and writes it to the log.
    pub(crate) fn refused(&self, fault: &Fault) {
        refusal::record(&self.services.metrics, fault);
    }

    /// Time of silence after which a stream gets a heartbeat.
    /// How streams are kept alive and when they end.
    pub(crate) fn pace(&self) -> Pace {
        let config = &self.services.config;
        Pace {
            heartbeat: config.heartbeat(),
            unread: config.unread_time(),
        }
    }

    pub(crate) fn metrics(&self) -> &Metrics {
        &self.services.metrics
    }

    /// Counts a stream as long as the guard lives.
    pub(crate) fn stream(self: &Arc<Self>) -> StreamGuard {
        self.streams.send_modify(|count| *count += 1);
        self.services.metrics.stream_opened();
        StreamGuard(Arc::clone(self))
    }

    /// Returns when no stream is open.
    pub(crate) async fn streams_gone(&self) {
        let mut streams = self.streams.subscribe();
        // The sender lives as long as this.
        let _gone = streams.wait_for(|count| *count == 0).await;
    }

    /// Refuses new work.
    pub(crate) fn check_open(&self) -> Result<(), Fault> {
        if self.draining.load(Ordering::SeqCst) {
            return Err(Fault::ShuttingDown);
        }
        self.services.check_data()
    }

    /// Whether probes shall send work here: it is taken, and can be kept.
    pub(crate) fn check_ready(&self) -> Result<(), Fault> {
        self.check_open()?;
        self.services.check_ready()
    }

    /// The session of that name, out of the data folder where it has to be. One of another
    /// client is not there.
    pub(crate) async fn get(
        self: &Arc<Self>,
        caller: &Caller,
        name: &str,
    ) -> Result<Handle, Fault> {
        self.get_for(caller, name, Wish::Look).await
    }

    /// As [`Registry::get`], for what the caller wants of it.
    pub(crate) async fn get_for(
        self: &Arc<Self>,
        caller: &Caller,
        name: &str,
        wish: Wish,
    ) -> Result<Handle, Fault> {
        caller.note(name);
        loop {
            let mut settled = pin!(self.settled.notified());
            // Registered before the look, so that no change falls between.
            settled.as_mut().enable();
            match self.find(caller, name) {
                Err(Fault::SessionNotFound(_)) if self.takes(name, wish).await? => {}
                Err(fault) => return Err(fault),
                Ok(found) => match found {
                    Found::Awake(handle) => return Ok(handle),
                    Found::Asleep(waking) => {
                        let spec = wake::spec(&self.services, name).await;
                        return Ok(waking
                            .claim()
                            .start(spec.inspect_err(|_| self.pass_on(name))?));
                    }
                    Found::Waking => settled.await,
                },
            }
        }
    }

    fn find(self: &Arc<Self>, caller: &Caller, name: &str) -> Result<Found, Fault> {
        let goes_on = self.services.journal.is_some();
        self.check_open().map_err(|fault| match goes_on {
            // Whoever comes back in the middle of a restart shall come again.
            true => Fault::Interrupted,
            false => fault,
        })?;
        if name.len() > LONGEST_NAME {
            return Err(Fault::request("name", "is longer than 256 bytes"));
        }
        let mut inner = self.lock();
        if !inner.may_see(caller, name) {
            return Err(Fault::SessionNotFound(name.to_owned()));
        }
        if let Some(Some(handle)) = inner.sessions.get(name) {
            return Ok(Found::Awake(handle.clone()));
        }
        if let Some(sleeper) = inner.asleep.get_mut(name) {
            if std::mem::replace(&mut sleeper.is_waking, true) {
                return Ok(Found::Waking);
            }
            let (registry, name) = (Arc::clone(self), name.to_owned());
            return Ok(Found::Asleep(Waking { registry, name }));
        }
        let is_it = |(one, owner): &(String, _)| one == name && caller.may_see(*owner);
        let is_expired = inner.expired.iter().any(is_it);
        let name = name.to_owned();
        if is_expired {
            return Err(Fault::SessionExpired(name));
        }
        Err(Fault::SessionNotFound(name))
    }

    /// Takes a name for a session to be made, or returns the one that an earlier
    /// request of this identifier made; waits while that one is being made.
    pub(crate) async fn claim(
        self: &Arc<Self>,
        (caller, client): (&Caller, ClientIdentity),
        id: &str,
        request_id: &str,
    ) -> Result<Claimed, Fault> {
        let name = match id {
            "" => new_name(),
            id => checked_name(id)?,
        };
        self.check_open()?;
        let is_known = self.lock().contains(&name);
        if !is_known {
            self.ask(&name, Wish::Look).await?;
        }
        loop {
            let mut settled = pin!(self.settled.notified());
            // Registered before the look, so that no change falls between.
            settled.as_mut().enable();
            let tried = self.try_claim((caller, client), &name, request_id);
            if !self.lock().contains(&name) {
                self.release(&name);
            }
            match tried? {
                Some(Ok(claim)) => return Ok(Claimed::New(claim)),
                Some(Err(made)) => {
                    return Ok(Claimed::Made(Box::pin(self.get(caller, &made)).await?));
                }
                None => settled.await,
            }
        }
    }

    /// As [`Registry::claim`], with the name of a session that is there; `None` while the
    /// session of this request is being made.
    fn try_claim(
        self: &Arc<Self>,
        (caller, client): (&Caller, ClientIdentity),
        name: &str,
        request_id: &str,
    ) -> Result<Option<Result<Claim, String>>, Fault> {
        self.check_open()?;
        let name = name.to_owned();
        let request = (caller.name(), request_id.to_owned());
        let mut inner = self.lock();
        if let Some(made) = inner.of_request(&request) {
            return Ok(made.map(Err));
        }
        self.check_room(&inner, client)?;
        if inner.contains(&name) {
            return Err(Fault::SessionExists(name));
        }
        inner.sessions.insert(name.clone(), None);
        if !request_id.is_empty() {
            inner.requests.insert(request, name.clone());
        }
        if let Some(owner) = caller.name() {
            inner.owners.insert(name.clone(), owner);
        }
        inner.clients.insert(name.clone(), client);
        caller.note(&name);
        let registry = Arc::clone(self);
        Ok(Some(Ok(Claim { registry, name })))
    }

    /// Refuses one more session than there may be, in all or of one client.
    fn check_room(&self, inner: &Directory, client: ClientIdentity) -> Result<(), Fault> {
        let config = &self.services.config;
        let refused = |limit| Err(Fault::SessionLimit { limit });
        let own = inner.count_of(client);
        match (config.maximum_sessions, config.maximum_client_sessions) {
            (limit, _) if inner.len() >= limit => refused(limit),
            (_, limit) if limit > 0 && own >= limit => refused(limit),
            _ => Ok(()),
        }
    }

    /// Up to `count` sessions that only the data folder has after `after`, in order of
    /// their names.
    pub(crate) fn list_asleep(
        &self,
        caller: &Caller,
        after: &str,
        count: usize,
    ) -> Vec<wire::Session> {
        let inner = self.lock();
        let later = inner.asleep.values().map(|one| &one.described);
        let is_shown =
            |one: &&wire::Session| one.name.as_str() > after && inner.may_see(caller, &one.name);
        let later = later.filter(is_shown);
        later.take(count).cloned().collect()
    }

    /// Sessions that only the data folder has and that need the mesh `name`.
    pub(crate) fn asleep_on(&self, name: &str) -> usize {
        let inner = self.lock();
        let on = |one: &&Sleeper| one.described.mesh == name;
        inner.asleep.values().filter(on).count()
    }

    /// Sessions that only the data folder has and whose tools need the surface `name`.
    pub(crate) fn asleep_with(&self, name: &str) -> usize {
        let inner = self.lock();
        let with = |one: &&Sleeper| one.surfaces.iter().any(|one| one == name);
        inner.asleep.values().filter(with).count()
    }

    /// Forgets those whose time to live has passed; nobody called for them.
    pub(crate) async fn expire_asleep(&self) {
        let Some(journal) = &self.services.journal else {
            return;
        };
        let over = |one: &Sleeper| !one.is_waking && one.since.elapsed() >= one.ttl;
        let names: Vec<String> = {
            let mut inner = self.lock();
            let all = inner.asleep.iter_mut().filter(|(_, one)| over(one));
            all.map(|(name, one)| {
                one.is_waking = true;
                name.clone()
            })
            .collect()
        };
        for name in names {
            match journal.store(&name, vec![Change::Delete]).await {
                Ok(()) => self.ended(&name, &SessionEnd::Expired),
                Err(why) => tracing::error!(why = why.to_string(), "a session stays on disk"),
            }
        }
    }

    /// Up to `count` sessions after `after`, in order of their names.
    pub(crate) fn list(&self, caller: &Caller, after: &str, count: usize) -> Vec<(String, Handle)> {
        let inner = self.lock();
        let is_shown = |name: &str| name > after && inner.may_see(caller, name);
        let later = inner.sessions.iter().filter(|(name, _)| is_shown(name));
        let made = later.filter_map(|(name, handle)| Some((name.clone(), handle.clone()?)));
        made.take(count).collect()
    }

    /// Every session that has an actor.
    fn awake(&self) -> Vec<Handle> {
        self.lock().sessions.values().flatten().cloned().collect()
    }

    /// Stops every session, refuses new ones, and returns when all have ended.
    pub(crate) async fn drain(&self) {
        self.draining.store(true, Ordering::SeqCst);
        let all = self.awake();
        for handle in &all {
            handle.shut_down().await;
        }
        for handle in &all {
            handle.ended().await;
        }
    }

    /// The server is about to close its journal.
    pub(crate) fn close(&self) {
        self.closed.store(true, Ordering::SeqCst);
    }

    fn ended(&self, name: &str, ending: &SessionEnd) {
        let stored = self.stored(name, ending);
        let mut inner = self.lock();
        let owner = inner.owners.get(name).copied();
        match stored {
            Some(listed) => {
                inner.sessions.remove(name);
                inner.enter(name.to_owned(), &listed, &self.services.config);
            }
            None => {
                inner.forget(name);
                self.release(name);
            }
        }
        if *ending == SessionEnd::Expired {
            inner.expired.push_back((name.to_owned(), owner));
            if inner.expired.len() > REMEMBERED {
                inner.expired.pop_front();
            }
        }
        self.services.metrics.sessions(inner.sessions.len());
        self.services.metrics.asleep(inner.asleep.len());
    }

    /// What the data folder has of a session that goes on later.
    fn stored(&self, name: &str, ending: &SessionEnd) -> Option<Listed> {
        if self.closed.load(Ordering::SeqCst) {
            // The transport has ended, and the journal may have: nobody asks any more.
            return None;
        }
        let journal = self.services.journal.as_ref()?;
        // In a fleet it goes on where it is asked for.
        let stays = ending.is_interruption() && self.services.fleet.is_none();
        stays.then(|| journal.listed(name))?
    }

    fn lock(&self) -> MutexGuard<'_, Directory> {
        // No code of others runs under the lock, so a poisoned state is whole.
        self.directory
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

/// An open stream.
pub(crate) struct StreamGuard(Arc<Registry>);

impl Drop for StreamGuard {
    fn drop(&mut self) {
        self.0.streams.send_modify(|count| *count -= 1);
        self.0.services.metrics.stream_closed();
    }
}
