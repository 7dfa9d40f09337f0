//! Who calls, as far as it matters to what belongs to somebody.

use std::sync::{Arc, OnceLock};

use tokio::sync::watch;
use tonic::Request;

use super::{Entry, TokenFile};
use crate::door::client_name::ClientName;

/// The caller of one call. Clones are the same call.
#[derive(Clone)]
pub(crate) struct Caller {
    name: Option<ClientName>,
    sees_all: bool,
    /// What the call is about, for its audit line.
    about: Arc<OnceLock<String>>,
    /// As long as it stands, the caller may go on.
    standing: Option<(Entry, watch::Receiver<Arc<TokenFile>>)>,
}

impl Caller {
    /// One of a server that asks nobody, and to which all belongs to all.
    pub(super) fn anybody() -> Self {
        Self {
            sees_all: true,
            ..Self::nobody()
        }
    }

    /// One that was not asked on a server that asks.
    pub(super) fn nobody() -> Self {
        Self {
            name: None,
            sees_all: false,
            about: Arc::default(),
            standing: None,
        }
    }

    /// One that an entry lets in.
    pub(super) fn known(entry: Entry, tokens: watch::Receiver<Arc<TokenFile>>) -> Self {
        Self {
            name: Some(entry.name()),
            sees_all: entry.role() == super::Role::Admin,
            about: Arc::default(),
            standing: Some((entry, tokens)),
        }
    }

    /// The caller of a request.
    pub(crate) fn of<T>(request: &Request<T>) -> Self {
        let found = request.extensions().get::<Self>().cloned();
        found.unwrap_or_else(Self::nobody)
    }

    /// Whom what this caller makes belongs to; nobody where nobody is asked.
    pub(crate) fn name(&self) -> Option<ClientName> {
        self.name
    }

    /// Whether everything is there for this caller.
    pub(crate) fn sees_all(&self) -> bool {
        self.sees_all
    }

    /// Whether what belongs to `owner` is there for this caller; what belongs to nobody is there
    /// for all.
    pub(crate) fn may_see(&self, owner: Option<ClientName>) -> bool {
        self.sees_all || owner.is_none() || owner == self.name
    }

    /// Notes what the call is about; the first note stays.
    pub(crate) fn note(&self, resource: &str) {
        // A second note of the same call adds nothing.
        let _kept = self.about.set(crate::fault::status::shortened(resource));
    }

    pub(super) fn about(&self) -> &str {
        self.about.get().map_or("", String::as_str)
    }

    /// Returns when the caller's entry is revoked or changed; never where nobody is asked.
    pub(crate) async fn revoked(&self) {
        let Some((entry, tokens)) = &self.standing else {
            return std::future::pending().await;
        };
        let gone = |tokens: &Arc<TokenFile>| !tokens.has(entry);
        let mut tokens = tokens.clone();
        // The sender lives as long as the server.
        let _over = tokens.wait_for(gone).await;
    }
}
