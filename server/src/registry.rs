//! The sessions of a server, by name.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::pin::pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use prost::Message as _;
use signorini_proto::v1 as wire;
use tokio::sync::{Notify, watch};
use tokio::time::Instant;

use crate::access::Caller;
use crate::client_name::ClientName;
use crate::config::Config;
use crate::convert::{step, surface};
use crate::fault::Fault;
use crate::journal::{Change, JournalError, Listed};
use crate::metrics::Metrics;
use crate::session::{self, Handle, Services, SessionEnd, SessionSpec};
use crate::status;
use crate::wake;

const PREFIX: &str = "sessions/";
/// Names of expired sessions that are remembered, to say so.
const REMEMBERED: usize = 1000;
/// Bytes of a name in a request.
const LONGEST_NAME: usize = 256;
const SHORTEST_ID: usize = 4;
const LONGEST_ID: usize = 63;

/// The sessions by name, and by the requests that made them.
#[derive(Default)]
struct Directory {
    /// `None` while a session is being made.
    sessions: BTreeMap<String, Option<Handle>>,
    /// Session name by whose request it was and its identifier.
    requests: HashMap<(Option<ClientName>, String), String>,
    /// Whom sessions belong to, those that are being made included; the others belong to all.
    owners: HashMap<String, ClientName>,
    expired: VecDeque<(String, Option<ClientName>)>,
    /// Those that the data folder has and no actor.
    asleep: BTreeMap<String, Sleeper>,
}

/// A session that only the data folder has.
#[derive(Clone)]
struct Sleeper {
    /// As lists show it.
    described: wire::Session,
    /// Names of its tools' surfaces.
    surfaces: Vec<String>,
    ttl: Duration,
    since: Instant,
    is_waking: bool,
}

/// Where a session is.
enum Found {
    Awake(Handle),
    /// The caller wakes it.
    Asleep(Waking),
    /// Another call wakes it.
    Waking,
}

impl Directory {
    /// The session of a request, if one is made or being made (`None` inside).
    fn of_request(&self, request: &(Option<ClientName>, String)) -> Option<Option<String>> {
        let name = self.requests.get(request)?;
        let is_made = match self.sessions.get(name) {
            Some(handle) => handle.is_some(),
            None => self.asleep.contains_key(name),
        };
        Some(is_made.then(|| name.clone()))
    }

    /// Enters a session that only the data folder has.
    fn enter(&mut self, name: String, listed: &Listed, config: &Config) {
        // One that cannot be read is told so when it is called.
        let request = wire::CreateSessionRequest::decode(listed.session.request.clone());
        let request = request.unwrap_or_default();
        let owner = wake::owner(listed);
        if !request.request_id.is_empty() {
            let request = (owner, request.request_id.clone());
            self.requests.insert(request, name.clone());
        }
        if let Some(owner) = owner {
            self.owners.insert(name.clone(), owner);
        }
        let ttl = step::duration(request.ttl.as_ref(), "ttl");
        let sleeper = Sleeper {
            described: wake::described(&name, listed),
            surfaces: request
                .scene
                .as_ref()
                .map(surface::names)
                .unwrap_or_default(),
            ttl: ttl.ok().flatten().unwrap_or_else(|| config.ttl()),
            since: Instant::now(),
            is_waking: false,
        };
        self.asleep.insert(name, sleeper);
    }

    fn len(&self) -> usize {
        self.sessions.len() + self.asleep.len()
    }

    /// Sessions of one owner.
    fn count_of(&self, owner: ClientName) -> usize {
        self.owners.values().filter(|one| **one == owner).count()
    }

    fn may_see(&self, caller: &Caller, name: &str) -> bool {
        caller.may_see(self.owners.get(name).copied())
    }

    fn contains(&self, name: &str) -> bool {
        self.sessions.contains_key(name) || self.asleep.contains_key(name)
    }

    fn forget(&mut self, name: &str) {
        self.sessions.remove(name);
        self.asleep.remove(name);
        self.owners.remove(name);
        self.requests.retain(|_, session| session != name);
    }
}

/// All sessions.
pub(crate) struct Registry {
    directory: Mutex<Directory>,
    draining: AtomicBool,
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
            settled: Notify::new(),
            streams: watch::Sender::new(0),
            services: Arc::clone(services),
        }))
    }

    /// Counts a refused request and writes it to the log.
    pub(crate) fn refused(&self, fault: &Fault) {
        let reason = status::reason(fault);
        self.services.metrics.refused(reason);
        tracing::info!(reason, why = status::text(fault), "request refused");
    }

    /// Time of silence after which a stream gets a heartbeat.
    pub(crate) fn heartbeat(&self) -> Duration {
        self.services.config.heartbeat()
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
        match self.draining.load(Ordering::SeqCst) {
            true => Err(Fault::ShuttingDown),
            false => Ok(()),
        }
    }

    /// The session of that name, out of the data folder where it has to be. One of another
    /// client is not there.
    pub(crate) async fn get(
        self: &Arc<Self>,
        caller: &Caller,
        name: &str,
    ) -> Result<Handle, Fault> {
        caller.note(name);
        loop {
            let mut settled = pin!(self.settled.notified());
            // Registered before the look, so that no change falls between.
            settled.as_mut().enable();
            match self.find(caller, name)? {
                Found::Awake(handle) => return Ok(handle),
                Found::Asleep(waking) => {
                    let spec = wake::spec(&self.services, name).await?;
                    return Ok(waking.claim().start(spec));
                }
                Found::Waking => settled.await,
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
        caller: &Caller,
        id: &str,
        request_id: &str,
    ) -> Result<Claimed, Fault> {
        loop {
            let mut settled = pin!(self.settled.notified());
            // Registered before the look, so that no change falls between.
            settled.as_mut().enable();
            match self.try_claim(caller, id, request_id)? {
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
        caller: &Caller,
        id: &str,
        request_id: &str,
    ) -> Result<Option<Result<Claim, String>>, Fault> {
        self.check_open()?;
        let name = match id {
            "" => new_name(),
            id => checked_name(id)?,
        };
        let request = (caller.name(), request_id.to_owned());
        let mut inner = self.lock();
        if let Some(made) = inner.of_request(&request) {
            return Ok(made.map(Err));
        }
        self.check_room(&inner, caller)?;
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
        caller.note(&name);
        let registry = Arc::clone(self);
        Ok(Some(Ok(Claim { registry, name })))
    }

    /// Refuses one more session than there may be, in all or of one client.
    fn check_room(&self, inner: &Directory, caller: &Caller) -> Result<(), Fault> {
        let config = &self.services.config;
        let refused = |limit| Err(Fault::SessionLimit { limit });
        let own = caller.name().map_or(0, |name| inner.count_of(name));
        match (config.maximum_sessions, config.maximum_client_sessions) {
            (limit, _) if inner.len() >= limit => refused(limit),
            (_, limit) if limit > 0 && own >= limit => refused(limit),
            _ => Ok(()),
        }
    }

    /// Up to `count` sessions that only the data folder has behind `after`, in order of
    /// their names.
    pub(crate) fn list_asleep(
        &self,
        caller: &Caller,
        after: &str,
        count: usize,
    ) -> Vec<wire::Session> {
        let inner = self.lock();
        let behind = inner.asleep.values().map(|one| &one.described);
        let is_shown =
            |one: &&wire::Session| one.name.as_str() > after && inner.may_see(caller, &one.name);
        let behind = behind.filter(is_shown);
        behind.take(count).cloned().collect()
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

    /// Up to `count` sessions behind `after`, in order of their names.
    pub(crate) fn list(&self, caller: &Caller, after: &str, count: usize) -> Vec<(String, Handle)> {
        let inner = self.lock();
        let is_shown = |name: &str| name > after && inner.may_see(caller, name);
        let behind = inner.sessions.iter().filter(|(name, _)| is_shown(name));
        let made = behind.filter_map(|(name, handle)| Some((name.clone(), handle.clone()?)));
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

    fn ended(&self, name: &str, ending: &SessionEnd) {
        let stored = self.stored(name, ending);
        let mut inner = self.lock();
        let owner = inner.owners.get(name).copied();
        match stored {
            Some(listed) => {
                inner.sessions.remove(name);
                inner.enter(name.to_owned(), &listed, &self.services.config);
            }
            None => inner.forget(name),
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
        let journal = self.services.journal.as_ref()?;
        ending.is_interruption().then(|| journal.listed(name))?
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

/// What a request to create a session finds.
pub(crate) enum Claimed {
    New(Claim),
    /// An earlier request of the same identifier made it.
    Made(Handle),
}

/// A session that is being woken; asleep again unless that succeeds.
struct Waking {
    registry: Arc<Registry>,
    name: String,
}

impl Waking {
    /// The name, for a session that starts under it.
    fn claim(&self) -> Claim {
        let (registry, name) = (Arc::clone(&self.registry), self.name.clone());
        Claim { registry, name }
    }
}

impl Drop for Waking {
    fn drop(&mut self) {
        if let Some(sleeper) = self.registry.lock().asleep.get_mut(&self.name) {
            sleeper.is_waking = false;
        }
        self.registry.settled.notify_waiters();
    }
}

/// A name taken; given back unless a session starts under it.
pub(crate) struct Claim {
    registry: Arc<Registry>,
    name: String,
}

impl Claim {
    /// `sessions/{id}`.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Starts the session.
    pub(crate) fn start(self, spec: SessionSpec) -> Handle {
        let registry = Arc::clone(&self.registry);
        let (by_name, name) = (Arc::clone(&registry), self.name.clone());
        // The lock keeps an actor that ends at once from being entered afterwards.
        let mut inner = registry.lock();
        let ended = move |ending| by_name.ended(&name, &ending);
        let handle = session::start(Arc::clone(&registry.services), spec, ended);
        inner.asleep.remove(&self.name);
        inner
            .sessions
            .insert(self.name.clone(), Some(handle.clone()));
        registry.services.metrics.sessions(inner.sessions.len());
        registry.services.metrics.asleep(inner.asleep.len());
        drop(inner);
        registry.settled.notify_waiters();
        handle
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        let mut inner = self.registry.lock();
        if let Some(None) = inner.sessions.get(&self.name) {
            inner.forget(&self.name);
        }
        drop(inner);
        self.registry.settled.notify_waiters();
    }
}

fn new_name() -> String {
    // Random keys of the standard hasher: enough for names nobody guesses by accident.
    let number = RandomState::new().build_hasher().finish();
    format!("{PREFIX}s{number:016x}")
}

fn checked_name(id: &str) -> Result<String, Fault> {
    let allowed = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'-';
    let starts = id
        .bytes()
        .next()
        .is_some_and(|byte| byte.is_ascii_lowercase());
    let fits = (SHORTEST_ID..=LONGEST_ID).contains(&id.len());
    if starts && fits && id.bytes().all(allowed) {
        return Ok(format!("{PREFIX}{id}"));
    }
    let rule = "must be 4 to 63 characters of a-z, 0-9 and hyphen, starting with a letter";
    Err(Fault::request("session_id", rule))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_follow_their_rule() {
        assert_eq!(checked_name("ball-1"), Ok("sessions/ball-1".into()));
        for bad in ["abc", "1abc", "Ball", "a/../b", "ba ll", &"a".repeat(64)] {
            assert!(checked_name(bad).is_err(), "{bad}");
        }
        assert!(checked_name(new_name().strip_prefix(PREFIX).unwrap()).is_ok());
        assert_ne!(new_name(), new_name());
    }
}
