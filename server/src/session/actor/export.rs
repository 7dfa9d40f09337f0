//! The state of a session as bytes, between two steps.
//!
//! A solver thread makes them; the session forgets what the solver has learnt, so the
//! state is a checkpoint of the journal too, before anybody hears of it.

use crate::compute::Length;
use std::sync::Arc;

use tokio::sync::oneshot;

use super::{Actor, Place, answer};
use crate::compute::Panicked;
use crate::fault::Fault;
use crate::journal::{Change, StoredCheckpoint, Urgency};
use crate::session::work::{Event, Handoff, Work};

/// Who waits for a state.
pub(super) type Exporter = oneshot::Sender<Result<Vec<u8>, Fault>>;

impl Actor {
    /// Sends the state to a solver thread if somebody waits for it and no step is in it;
    /// whether it did.
    pub(super) fn export(&mut self) -> bool {
        let current = self.queue.current();
        let is_between = current.is_none_or(|current| current.results == 0);
        if self.exporters.is_empty() || !is_between {
            return false;
        }
        let place = std::mem::replace(&mut self.place, Place::Away(Handoff::default()));
        let Place::Home(mut work) = place else {
            self.place = place;
            return false;
        };
        let (events, held) = (self.events.clone(), Arc::clone(&self.spec.reservation));
        self.services.solvers.submit(
            self.client.flow(self.number),
            Length::Short,
            move |_| {
                let bytes = work.session.export();
                drop(held);
                (work, bytes)
            },
            move |outcome| {
                // A session that is gone needs no state.
                let _gone = events.send(Event::Exported(outcome));
            },
        );
        true
    }

    pub(super) fn exported(&mut self, outcome: Result<(Box<Work>, Vec<u8>), Panicked>) {
        let (mut work, state) = match outcome {
            Ok(done) => done,
            Err(panicked) => {
                tracing::error!(said = panicked.0, "an export panicked");
                self.place = Place::Lost("a defect of the server; its log says more".to_owned());
                return;
            }
        };
        if matches!(self.place, Place::Behind) {
            // A step was stopped meanwhile: those who wait get the state behind it.
            work.stop();
            self.place = Place::Home(work);
            return;
        }
        self.place = Place::Home(work);
        let checkpoint = StoredCheckpoint {
            event: self.last_event,
            sequence: self.last_finished,
            done: 0,
            state: state.clone().into(),
        };
        let mark = self.record(vec![Change::Checkpoint(checkpoint)], Urgency::Now);
        let retained = self.services.config.retained_results;
        self.log.fix(mark, self.last_event, retained);
        for exporter in std::mem::take(&mut self.exporters) {
            self.exported.push((mark, exporter, state.clone()));
        }
        self.answer_exports();
    }

    /// Answers those whose state is on disk.
    pub(super) fn answer_exports(&mut self) {
        let durable = self.log.durable;
        let (there, waiting) = std::mem::take(&mut self.exported)
            .into_iter()
            .partition(|(mark, _, _)| *mark <= durable);
        self.exported = waiting;
        for (_, exporter, state) in there {
            answer(exporter, Ok(state));
        }
    }

    /// Nobody gets a state any more.
    pub(super) fn refuse_exports(&mut self, why: &Fault) {
        let waiting = std::mem::take(&mut self.exported).into_iter();
        let waiting = waiting.map(|(_, exporter, _)| exporter);
        for exporter in std::mem::take(&mut self.exporters)
            .into_iter()
            .chain(waiting)
        {
            answer(exporter, Err(why.clone()));
        }
    }
}
