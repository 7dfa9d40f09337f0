//! Whom an upload belongs to.

use std::collections::BTreeSet;

use super::Caller;
use crate::door::client_name::ClientName;

/// Everybody who has sent the same bytes; empty: they belong to nobody and are there for all.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Owners(BTreeSet<ClientName>);

impl Owners {
    /// Those of an upload by `caller`.
    pub(crate) fn of(caller: &Caller) -> Self {
        Self(caller.name().into_iter().collect())
    }

    /// As they were stored. A name that is none any more owns nothing.
    ///
    /// # Errors
    /// The name that this version does not know: dropping it could open the upload to all.
    pub(crate) fn from_stored(names: &[String]) -> Result<Self, String> {
        let parse = |name: &String| name.parse().map_err(|_| name.clone());
        names.iter().map(parse).collect::<Result<_, _>>().map(Self)
    }

    /// One of them, for whom the upload is counted.
    pub(crate) fn first(&self) -> Option<ClientName> {
        self.0.first().copied()
    }

    /// As they are stored.
    pub(crate) fn stored(&self) -> Vec<String> {
        self.0.iter().map(ClientName::to_string).collect()
    }

    /// Whether the upload is there for `caller`.
    pub(crate) fn admit(&self, caller: &Caller) -> bool {
        caller.sees_all()
            || self.0.is_empty()
            || caller.name().is_some_and(|name| self.0.contains(&name))
    }

    /// Counts one in who has sent the same bytes; whether that changes anything. What belongs to
    /// nobody stays so.
    pub(crate) fn join(&mut self, caller: &Caller) -> bool {
        let is_open = self.0.is_empty();
        caller
            .name()
            .is_some_and(|name| !is_open && self.0.insert(name))
    }

    /// Takes one out who deletes the upload, if it belongs to others too: then it stays.
    pub(crate) fn leave(&mut self, caller: &Caller) -> bool {
        let is_shared = self.0.len() > 1;
        caller
            .name()
            .is_some_and(|name| is_shared && self.0.remove(&name))
    }
}
