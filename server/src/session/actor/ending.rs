//! How a session ends: for good, or until it comes back out of the data folder.

use super::Actor;
use crate::fault::Fault;
use crate::journal::JournalError;
use crate::session::SessionEnd;

impl Actor {
    /// Stops everything; [`Actor::over`] says when that has happened.
    pub(super) fn end(&mut self, ending: SessionEnd) {
        let is_interruption = self.log.is_kept() && ending.is_interruption();
        self.ending.get_or_insert(ending);
        self.stop_preparing.cancel();
        if is_interruption {
            return self.interrupt();
        }
        for dropped in self.queue.keep_current() {
            self.reject(dropped.sequence, &self.parting());
        }
        self.cancel(0);
    }

    /// Ends a session that is another server's.
    pub(super) fn give_up(&mut self) {
        let why = JournalError::Elsewhere(self.spec.name.clone());
        self.end(SessionEnd::Interrupted(Some(why)));
    }

    /// As [`Actor::give_up`], unless somebody writes to it; whether it does.
    pub(super) fn give_away(&mut self) -> bool {
        let is_free = self.writer.is_none() && self.ending.is_none();
        if is_free {
            self.give_up();
        }
        is_free
    }

    /// Whether the session is another server's, or may be; it ends then.
    pub(super) fn is_given_up(&mut self) -> bool {
        let lease = self.spec.lease.as_ref();
        let is_lost = lease.is_some_and(|lease| !lease.holds());
        if is_lost {
            self.give_up();
        }
        is_lost
    }

    /// Whether it ends here and comes back out of the data folder.
    pub(super) fn goes_on_later(&self) -> bool {
        let ending = self.ending.as_ref();
        self.log.is_kept() && ending.is_some_and(SessionEnd::is_interruption)
    }

    pub(super) fn parting(&self) -> Fault {
        match &self.ending {
            Some(SessionEnd::ShutDown) if !self.log.is_kept() => Fault::ShuttingDown,
            Some(SessionEnd::ShutDown | SessionEnd::Interrupted(None)) => Fault::Interrupted,
            Some(SessionEnd::Interrupted(Some(JournalError::Elsewhere(name)))) => {
                let (name, owner) = (name.clone(), String::new());
                Fault::SessionElsewhere { name, owner }
            }
            Some(SessionEnd::Interrupted(Some(why))) => Fault::Unwritable(why.to_string()),
            Some(SessionEnd::Expired) => Fault::SessionExpired(self.spec.name.clone()),
            Some(SessionEnd::Deleted | SessionEnd::Died) | None => {
                Fault::SessionDeleted(self.spec.name.clone())
            }
        }
    }

    /// The ending, when nothing runs any more.
    pub(super) fn over(&mut self) -> Option<SessionEnd> {
        let ending = self.ending.clone().filter(|_| self.queue.is_empty())?;
        self.refuse_exports(&self.parting());
        self.end_streams(&self.parting());
        Some(ending)
    }
}
