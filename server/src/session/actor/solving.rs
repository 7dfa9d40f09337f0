//! What goes to the solver threads, and what comes back from them.

use std::sync::{Arc, PoisonError};

use signorini::report::{FieldName, Termination};

use super::{Actor, Loss, Place};
use crate::compute::{Length, Panicked};
use crate::door::client_key::Flow;
use crate::session::work::{self, Event, Handoff, Outcome, Preparation, Ready, Task};

impl Actor {
    pub(super) fn start_preparing(&mut self) {
        let replay = self.recover();
        let preparation = Preparation {
            plan: Arc::clone(&self.spec.plan),
            mesh: Arc::clone(self.spec.mesh.value()),
            flow: self.client.flow(self.number),
            cancel: self.stop_preparing.clone(),
            reservation: Arc::clone(&self.spec.reservation),
            replay,
        };
        let (services, events) = (Arc::clone(&self.services), self.events.clone());
        tokio::spawn(work::prepare(services, preparation, events));
    }

    pub(super) fn advanced(&mut self, outcome: Result<Outcome, Panicked>) {
        let is_late = matches!(self.place, Place::Behind);
        match outcome {
            Ok(Outcome::Withdrawn) => {}
            Ok(Outcome::Increment(work, increment)) if is_late => {
                self.undo_late(work, &increment);
            }
            Ok(Outcome::Refused(work, _) | Outcome::Broken(work, _)) if is_late => {
                self.come_home_late(work);
            }
            Ok(Outcome::Increment(work, increment)) => {
                self.place = Place::Home(work);
                self.finish_increment(*increment);
            }
            Ok(Outcome::Refused(work, error)) => {
                self.place = Place::Home(work);
                self.refuse_current(&error.into());
            }
            Ok(Outcome::Broken(work, why)) => {
                tracing::error!(why, "a step broke");
                self.place = Place::Home(work);
                self.finish_stopped(Termination::InternalError);
            }
            Err(panicked) => {
                tracing::error!(said = panicked.0, "a defect beside a step");
                self.place = Place::Lost(Loss::by_a_defect());
                self.finish_stopped(Termination::InternalError);
            }
        }
    }

    /// Sends the current step's next increment to a solver thread.
    pub(super) fn dispatch(&mut self) {
        if !matches!(self.place, Place::Home(_)) {
            return;
        }
        let (wanted, every) = (self.wanted(), self.spec.output.every);
        let scratch_bytes = self.scratch_bytes();
        let limit = self.spec.plan.scene().solver.max_wall_time;
        let ceiling = self.services.config.step_time();
        let length = if self.was_long {
            Length::Long
        } else {
            work::length(&self.spec.plan)
        };
        let Some(current) = self.queue.current() else {
            return;
        };
        current.start_clock(limit, &self.events);
        let (traces, sequence) = (&self.services.traces, current.sequence);
        let begin = || traces.update(&self.spec.name, sequence);
        let trace = current.trace.get_or_insert_with(begin).clone();
        current.start_ceiling(ceiling, &self.events);
        let task = Task {
            sequence: current.sequence,
            number: current.step_number(),
            step: current.step.clone(),
            cancel: current.cancel.clone(),
            clock: Arc::clone(&current.slot_clock),
            wanted,
            every,
            scratch_bytes,
            after_event: self.last_event,
            iterations: self.iterations.clone(),
            metrics: Arc::clone(&self.services.metrics),
            trace,
            ledger: self.log.ledger(),
            is_kept: self.log.is_kept(),
        };
        let handoff = Handoff::default();
        let empty = Place::Away(Arc::clone(&handoff));
        let Place::Home(work) = std::mem::replace(&mut self.place, empty) else {
            return;
        };
        *handoff.lock().unwrap_or_else(PoisonError::into_inner) = Some(work);
        let (span, events) = (tracing::Span::current(), self.events.clone());
        let held = Arc::clone(&self.spec.reservation);
        self.services.solvers.submit(
            self.flow(),
            length,
            move |slot| {
                let outcome = span.in_scope(|| work::advance(&handoff, &task, slot));
                // The memory may outlive the session that asked for it.
                drop(held);
                outcome
            },
            move |outcome| {
                // A session that is gone needs no result.
                let _gone = events.send(Event::Advanced(outcome));
            },
        );
    }

    /// The session's share of the solver threads: with whom it writes for, or with all that its
    /// client has left running.
    fn flow(&self) -> Flow {
        let is_attended = self.writer.is_some() || !self.watchers.is_empty();
        let client = if is_attended {
            self.client
        } else {
            self.client.unattended()
        };
        client.flow(self.number)
    }

    /// Fields that some reader wants; without a writer, those that the last one
    /// wanted, for it may come back.
    fn wanted(&self) -> Vec<FieldName> {
        let mut all = self.fields.clone();
        for watcher in self.watchers.values() {
            for field in watcher.reader.outbox.fields() {
                if !all.contains(field) {
                    all.push(*field);
                }
            }
        }
        all
    }

    pub(super) fn ready(&mut self, ready: Ready) {
        self.state_bytes = ready.state_bytes;
        self.response = ready.response;
        self.prepared = Some((ready.prepared, ready.reuse));
        self.spec.prepared = None;
        let mut work = ready.work;
        if std::mem::take(&mut self.is_stopped_early) {
            work.stop();
        }
        self.place = Place::Home(work);
        self.replayed(ready.replayed);
        self.note_response();
        self.account();
    }
}
