//! The sessions by name: those that have an actor, and those that only the data folder has.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::time::Duration;

use prost::Message as _;
use signorini_proto::v1 as wire;
use tokio::time::Instant;

use crate::config::Config;
use crate::convert::{step, surface};
use crate::door::access::Caller;
use crate::door::client_key::ClientIdentity;
use crate::door::client_name::ClientName;
use crate::journal::Listed;
use crate::registry::wake;
use crate::session::Handle;

/// The sessions by name, and by the requests that made them.
#[derive(Default)]
pub(super) struct Directory {
    /// `None` while a session is being made.
    pub(super) sessions: BTreeMap<String, Option<Handle>>,
    /// Session name by whose request it was and its identifier.
    pub(super) requests: HashMap<(Option<ClientName>, String), String>,
    /// Who made sessions, those that are being made included, as far as that is known: a data
    /// folder knows names only.
    pub(super) clients: HashMap<String, ClientIdentity>,
    /// Whom sessions belong to, those that are being made included; the others belong to all.
    pub(super) owners: HashMap<String, ClientName>,
    pub(super) expired: VecDeque<(String, Option<ClientName>)>,
    /// Those that the data folder has and no actor.
    pub(super) asleep: BTreeMap<String, Sleeper>,
}

/// A session that only the data folder has.
#[derive(Clone)]
pub(super) struct Sleeper {
    /// As lists show it.
    pub(super) described: wire::Session,
    /// Names of its tools' surfaces.
    pub(super) surfaces: Vec<String>,
    pub(super) ttl: Duration,
    pub(super) since: Instant,
    pub(super) is_waking: bool,
}

impl Directory {
    /// The session of a request, if one is made or being made (`None` inside).
    pub(super) fn of_request(
        &self,
        request: &(Option<ClientName>, String),
    ) -> Option<Option<String>> {
        let name = self.requests.get(request)?;
        let is_made = match self.sessions.get(name) {
            Some(handle) => handle.is_some(),
            None => self.asleep.contains_key(name),
        };
        Some(is_made.then(|| name.clone()))
    }

    /// Enters a session that only the data folder has.
    pub(super) fn enter(&mut self, name: String, listed: &Listed, config: &Config) {
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
            let client = ClientIdentity::Named(owner);
            self.clients.insert(name.clone(), client);
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

    pub(super) fn len(&self) -> usize {
        self.sessions.len() + self.asleep.len()
    }

    /// Sessions of one client.
    pub(super) fn count_of(&self, client: ClientIdentity) -> usize {
        self.clients.values().filter(|one| **one == client).count()
    }

    pub(super) fn may_see(&self, caller: &Caller, name: &str) -> bool {
        caller.may_see(self.owners.get(name).copied())
    }

    pub(super) fn contains(&self, name: &str) -> bool {
        self.sessions.contains_key(name) || self.asleep.contains_key(name)
    }

    pub(super) fn forget(&mut self, name: &str) {
        self.sessions.remove(name);
        self.asleep.remove(name);
        self.owners.remove(name);
        self.clients.remove(name);
        self.requests.retain(|_, session| session != name);
    }
}
