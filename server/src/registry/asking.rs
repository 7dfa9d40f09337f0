//! Sessions of a fleet: asked for, one question for a session at a time, given away and given up.
//!
//! What is in the directory of a server of a fleet, that server holds; the rest is elsewhere.

use std::collections::HashSet;
use std::pin::pin;
use std::sync::{Arc, MutexGuard, PoisonError};

use super::Registry;
use super::names::checked_name;
use crate::fault::Fault;
use crate::fleet::{self, Wish};
use crate::registry::planning;

/// A question that is being asked.
struct Asking {
    registry: Arc<Registry>,
    name: String,
}

impl Asking {
    /// Begins one, or waits for the one that somebody else asks; none then.
    async fn begin(registry: &Arc<Registry>, name: &str) -> Option<Self> {
        let mut settled = pin!(registry.settled.notified());
        // Registered before the look, so that no change falls between.
        settled.as_mut().enable();
        if registry.asked().insert(name.to_owned()) {
            let (registry, name) = (Arc::clone(registry), name.to_owned());
            return Some(Self { registry, name });
        }
        settled.await;
        None
    }
}

impl Registry {
    /// Asks the fleet for a session that this server does not have; whether to look again.
    ///
    /// # Errors
    /// `SessionElsewhere`, and others of the fleet.
    pub(super) async fn takes(self: &Arc<Self>, name: &str, wish: Wish) -> Result<bool, Fault> {
        if checked_name(name.strip_prefix("sessions/").unwrap_or_default()).is_err() {
            return Ok(false);
        }
        match self.ask(name, wish).await? {
            Some(fleet::Found::Taken) => Ok(true),
            Some(fleet::Found::New) => {
                self.release(name);
                Ok(false)
            }
            None => Ok(false),
        }
    }

    /// Asks the fleet, if there is one, for a session, which is asleep here if it is taken; one
    /// question for a session at a time.
    pub(super) async fn ask(
        self: &Arc<Self>,
        name: &str,
        wish: Wish,
    ) -> Result<Option<fleet::Found>, Fault> {
        let (Some(fleet), Some(journal)) = (&self.services.fleet, &self.services.journal) else {
            return Ok(None);
        };
        let Some(_asking) = Asking::begin(self, name).await else {
            return Ok(Some(fleet::Found::Taken));
        };
        let found = fleet.ask(name, wish).await?;
        if found == fleet::Found::Taken {
            let (journal, owned) = (Arc::clone(journal), name.to_owned());
            let listed = planning::aside(move || journal.listed(&owned)).await?;
            let listed = listed.unwrap_or_default();
            let mut inner = self.lock();
            inner.enter(name.to_owned(), &listed, &self.services.config);
            self.services.metrics.asleep(inner.asleep.len());
        }
        Ok(Some(found))
    }

    /// Ends the sessions that are another server's, as they turn out, until it is dropped.
    pub(crate) async fn keep_leases(self: Arc<Self>) {
        let Some(fleet) = &self.services.fleet else {
            return;
        };
        let lost = |name: &str| {
            let mut inner = self.lock();
            if let Some(Some(handle)) = inner.sessions.get(name) {
                handle.give_up();
            } else if inner.asleep.get(name).is_some_and(|one| !one.is_waking) {
                inner.forget(name);
            }
        };
        fleet.keep(lost).await;
    }

    /// Gives sessions that nobody writes to to the servers that ask for them, until it is dropped.
    pub(crate) async fn grant_wishes(self: Arc<Self>) {
        let Some(fleet) = &self.services.fleet else {
            return;
        };
        let Some(mut wishes) = fleet.wishes().await else {
            return;
        };
        while let Some((name, answer)) = wishes.recv().await {
            let registry = Arc::clone(&self);
            tokio::spawn(async move {
                // Who asked may have left.
                let _left = answer.send(registry.give_away(&name).await);
            });
        }
    }

    /// Ends a session that nobody writes to; whether it did.
    async fn give_away(&self, name: &str) -> bool {
        let handle = self.lock().sessions.get(name).cloned().flatten();
        let Some(handle) = handle else {
            return false;
        };
        let is_given = handle.give_away().await;
        if is_given {
            handle.ended().await;
        }
        is_given
    }

    /// Another server may have the room for a session that this one lacks.
    pub(super) fn pass_on(&self, name: &str) {
        if self.services.fleet.is_some() {
            self.lock().forget(name);
            self.release(name);
        }
    }

    /// The session is no more this server's.
    pub(super) fn release(&self, name: &str) {
        if let Some(fleet) = &self.services.fleet {
            fleet.release(name);
        }
    }

    fn asked(&self) -> MutexGuard<'_, HashSet<String>> {
        self.asked.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Asking {
    fn drop(&mut self) {
        self.registry.asked().remove(&self.name);
        self.registry.settled.notify_waiters();
    }
}
