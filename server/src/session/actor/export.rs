//! The state of a session as bytes, between two steps: exported, saved, or gone back to.
//!
//! A solver thread makes or reads them; the session forgets what the solver has learnt, so the
//! state is a checkpoint of the journal too, before anybody hears of it.

use std::collections::VecDeque;
use std::sync::Arc;

use bytes::Bytes;
use tokio::sync::oneshot;

use super::memory::lock;
use super::{Actor, Loss, Place, answer};
use crate::compute::{Length, Panicked};
use crate::fault::Fault;
use crate::journal::{Change, StoredCheckpoint, StoredSave, Urgency};
use crate::session::work::{Event, Exported, Handoff, Work};

/// What somebody wants of the state.
pub(super) enum Visit {
    /// Its bytes.
    Export(oneshot::Sender<Result<Vec<u8>, Fault>>),
    /// It kept, and the number and the bytes of that.
    Save(oneshot::Sender<Result<(i64, u64), Fault>>),
    /// The kept one of that number in its place.
    Restore(i64, oneshot::Sender<Result<(), Fault>>),
}

impl Visit {
    fn refuse(self, why: Fault) {
        match self {
            Self::Export(reply) => answer(reply, Err(why)),
            Self::Save(reply) => answer(reply, Err(why)),
            Self::Restore(_, reply) => answer(reply, Err(why)),
        }
    }
}

/// An answer that waits for the disk.
pub(super) enum Visited {
    Exported(oneshot::Sender<Result<Vec<u8>, Fault>>, Bytes),
    Saved(oneshot::Sender<Result<(i64, u64), Fault>>, (i64, u64)),
    Restored(oneshot::Sender<Result<(), Fault>>),
}

impl Visited {
    fn answer(self, outcome: Result<(), Fault>) {
        match self {
            Self::Exported(reply, state) => answer(reply, outcome.map(|()| state.to_vec())),
            Self::Saved(reply, save) => answer(reply, outcome.map(|()| save)),
            Self::Restored(reply) => answer(reply, outcome),
        }
    }
}

/// Who waits for the state, who has it, and for whose answer the disk is waited for.
#[derive(Default)]
pub(super) struct Visits {
    /// Each with the update after which it comes.
    waiting: VecDeque<(i64, Visit)>,
    there: Vec<Visit>,
    done: Vec<(u64, Visited)>,
}

impl Actor {
    /// Takes a wish to the state. Saved and restored is after every update accepted so far:
    /// one whose result a client has seen may have to be done again after a kill.
    pub(super) fn visit(&mut self, visit: Visit) {
        let due = match visit {
            Visit::Export(_) => 0,
            Visit::Save(_) | Visit::Restore(..) => self.queue.last_accepted(),
        };
        self.visits.waiting.push_back((due, visit));
    }

    /// Whether the next one that waits may come to the state.
    fn is_visit_due(&mut self) -> bool {
        let next = self.queue.current().map(|one| (one.sequence, one.results));
        let (sequence, results) = next.unwrap_or((i64::MAX, 0));
        let front = self.visits.waiting.front();
        results == 0 && front.is_some_and(|(due, _)| *due < sequence)
    }

    /// Sends the state to a solver thread if somebody waits for it and no step is in it;
    /// whether it did.
    pub(super) fn export(&mut self) -> bool {
        if !self.is_visit_due() {
            return false;
        }
        let place = std::mem::replace(&mut self.place, Place::Away(Handoff::default()));
        let Place::Home(work) = place else {
            self.place = place;
            return false;
        };
        match self.next_visits() {
            Some(restored) => self.send_state(work, restored),
            None => self.place = Place::Home(work),
        }
        true
    }

    /// Lets the next ones to the state: those who only look at it together, who changes it
    /// alone; the state that shall take its place. None where the only one was refused.
    fn next_visits(&mut self) -> Option<Option<Bytes>> {
        if let Some((_, Visit::Restore(number, _))) = self.visits.waiting.front() {
            let (number, state) = (*number, self.saves.get(*number));
            let (_, visit) = self.visits.waiting.pop_front()?;
            let Some(state) = state else {
                let name = format!("{} of {}", number, self.spec.name);
                visit.refuse(Fault::StateNotFound(name));
                return None;
            };
            self.visits.there = vec![visit];
            return Some(Some(state));
        }
        let is_look = |(_, visit): &(i64, Visit)| !matches!(visit, Visit::Restore(..));
        while self.is_visit_due() && self.visits.waiting.front().is_some_and(is_look) {
            let next = self.visits.waiting.pop_front();
            self.visits.there.extend(next.map(|(_, visit)| visit));
        }
        Some(None)
    }

    fn send_state(&self, mut work: Box<Work>, restored: Option<Bytes>) {
        let (events, held) = (self.events.clone(), Arc::clone(&self.spec.reservation));
        self.services.solvers.submit(
            self.client.flow(self.number),
            Length::Short,
            move |_| {
                let state = match restored {
                    None => Ok(Bytes::from(work.session.export())),
                    Some(state) => match work.session.restore(&state) {
                        Ok(()) => Ok(state),
                        Err(why) => Err(Fault::StateInvalid(why.to_string())),
                    },
                };
                drop(held);
                (work, state)
            },
            move |outcome| {
                // A session that is gone needs no state.
                let _gone = events.send(Event::Exported(outcome));
            },
        );
    }

    pub(super) fn exported(&mut self, outcome: Result<Exported, Panicked>) {
        let there = std::mem::take(&mut self.visits.there);
        let (mut work, state) = match outcome {
            Ok(done) => done,
            Err(panicked) => {
                tracing::error!(said = panicked.0, "an export panicked");
                self.visits.there = there;
                self.place = Place::Lost(Loss::by_a_defect());
                return;
            }
        };
        if matches!(self.place, Place::Behind) {
            // A step was stopped meanwhile: those who wait get the state after it.
            work.stop();
            self.place = Place::Home(work);
            let again = there.into_iter().rev().map(|visit| (0, visit));
            again.for_each(|one| self.visits.waiting.push_front(one));
            return;
        }
        self.place = Place::Home(work);
        match state {
            Ok(state) => self.visited(there, &state),
            Err(why) => there
                .into_iter()
                .for_each(|visit| visit.refuse(why.clone())),
        }
    }

    /// Notes the state as a checkpoint, and keeps it where somebody wants that.
    fn visited(&mut self, there: Vec<Visit>, state: &Bytes) {
        let checkpoint = StoredCheckpoint {
            event: self.last_event,
            sequence: self.last_finished,
            done: 0,
            state: state.clone(),
        };
        let mut changes = vec![Change::Checkpoint(checkpoint)];
        let mut done = Vec::new();
        for visit in there {
            match visit {
                Visit::Export(reply) => done.push(Visited::Exported(reply, state.clone())),
                Visit::Restore(_, reply) => done.push(Visited::Restored(reply)),
                Visit::Save(reply) => match self.save(state, &mut changes) {
                    Ok(number) => done.push(Visited::Saved(reply, (number, state.len() as u64))),
                    Err(why) => answer(reply, Err(why)),
                },
            }
        }
        let mark = self.record(changes, Urgency::Now);
        let retained = self.services.config.retained_results;
        self.log.fix(mark, self.last_event, retained);
        let done = done.into_iter().map(|visited| (mark, visited));
        self.visits.done.extend(done);
        self.answer_exports();
    }

    /// Keeps a state, if there is memory for it; its number.
    fn save(&mut self, state: &Bytes, changes: &mut Vec<Change>) -> Result<i64, Fault> {
        let more = self
            .saves
            .bytes_with(state)
            .saturating_sub(self.saves.bytes());
        let held = self.held_bytes();
        let grown = lock(&self.spec.reservation).resize(held + more);
        grown.map_err(|lacking| Fault::MemoryBudget {
            predicted: state.len() as u64,
            held,
            budget: (held + more).saturating_sub(lacking),
        })?;
        let number = self.saves.keep(state.clone());
        let stored = StoredSave {
            state: state.clone(),
        };
        changes.push(Change::Save(number, stored));
        changes.push(Change::DropSaves(self.saves.first()));
        Ok(number)
    }

    /// Answers those whose state is on disk.
    pub(super) fn answer_exports(&mut self) {
        let durable = self.log.durable;
        let (there, waiting) = std::mem::take(&mut self.visits.done)
            .into_iter()
            .partition(|(mark, _)| *mark <= durable);
        self.visits.done = waiting;
        for (_, visited) in there {
            visited.answer(Ok(()));
        }
    }

    /// Nobody gets a state any more.
    pub(super) fn refuse_exports(&mut self, why: &Fault) {
        let Visits {
            waiting,
            there,
            done,
        } = std::mem::take(&mut self.visits);
        for (_, visited) in done {
            visited.answer(Err(why.clone()));
        }
        let waiting = waiting.into_iter().map(|(_, visit)| visit);
        for visit in waiting.chain(there) {
            visit.refuse(why.clone());
        }
    }
}
