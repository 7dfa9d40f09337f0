//! Names that are taken: by a session that is being made, or that is being woken.

use std::sync::Arc;

use super::Registry;
use crate::session::{self, Handle, SessionSpec};

/// What a request to create a session finds.
pub(crate) enum Claimed {
    New(Claim),
    /// An earlier request of the same identifier made it.
    Made(Handle),
}

/// A session that is being woken; asleep again unless that succeeds.
pub(super) struct Waking {
    pub(super) registry: Arc<Registry>,
    pub(super) name: String,
}

impl Waking {
    /// The name, for a session that starts under it.
    pub(super) fn claim(&self) -> Claim {
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
    pub(super) registry: Arc<Registry>,
    pub(super) name: String,
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
        let is_unused = matches!(inner.sessions.get(&self.name), Some(None));
        if is_unused {
            inner.forget(&self.name);
        }
        drop(inner);
        if is_unused {
            self.registry.release(&self.name);
        }
        self.registry.settled.notify_waiters();
    }
}
