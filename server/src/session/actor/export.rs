//! The state of a session as bytes, between two steps: exported, saved, or gone back to.
//!
//! What travels is how the state came about since the solver last knew nothing ([`Path`]), so that
//! whoever goes on from it has the same bits, and the session goes on as if nobody had looked. A
//! state that is gone back to is a checkpoint of the journal.

use std::collections::VecDeque;
use std::sync::Arc;

use signorini::Session;
use tokio::sync::oneshot;

use super::memory::lock;
use super::saves::{Save, Saves};
use super::{Actor, Loss, Path, Place, answer};
use crate::compute::{Length, Panicked};
use crate::fault::Fault;
use crate::journal::{Change, StoredCheckpoint, StoredSave, Urgency};
use crate::session::ledger::Ledger;
use crate::session::replay;
use crate::session::work::{Event, Exported, Handoff, Sight, Work};

/// What somebody wants of the state.
pub(super) enum Visit {
    /// Its bytes.
    Export(oneshot::Sender<Result<StoredSave, Fault>>),
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
    Exported(oneshot::Sender<Result<StoredSave, Fault>>, StoredSave),
    Saved(oneshot::Sender<Result<(i64, u64), Fault>>, (i64, u64)),
    Restored(oneshot::Sender<Result<(), Fault>>),
}

impl Visited {
    fn answer(self, outcome: Result<(), Fault>) {
        match self {
            Self::Exported(reply, state) => answer(reply, outcome.map(|()| state)),
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

/// What a solver thread does with the state.
enum Look {
    /// Nothing but what every look does.
    AtBytes,
    /// Copies it.
    AtAll,
    /// Puts a saved one in its place, doing again what led there where there is no copy; what
    /// that counts begins with the ledger.
    Back(Box<Save>, Ledger),
}

impl Look {
    fn at(self, work: &mut Work) -> Result<Sight, Fault> {
        let (save, ledger) = match self {
            Self::AtBytes => return Ok(Sight::default()),
            Self::AtAll => {
                let copy = Some(Arc::new(work.session.snapshot()));
                return Ok(Sight {
                    copy,
                    ..Sight::default()
                });
            }
            Self::Back(save, ledger) => (*save, ledger),
        };
        let (copy, ledger) = match save.copy {
            Some(copy) => {
                work.session.go_back(&copy);
                (copy, save.ledger)
            }
            None => {
                let ledger = led_back(&mut work.session, &save, ledger)?;
                (Arc::new(work.session.snapshot()), Some(ledger))
            }
        };
        Ok(Sight {
            start: None,
            copy: Some(copy),
            ledger,
        })
    }
}

/// Does again what led to a saved state; a session that does not come there is as before.
fn led_back(session: &mut Session, save: &Save, ledger: Ledger) -> Result<Ledger, Fault> {
    let before = session.snapshot();
    replay::redo(session, &save.stored, ledger).map_err(|why| {
        session.go_back(&before);
        Fault::StateInvalid(why.to_string())
    })
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
            Some(look) => self.send_state(work, look),
            None => self.place = Place::Home(work),
        }
        true
    }

    /// Lets the next ones to the state: those who only look at it together, who changes it
    /// alone. None where the only one was refused.
    fn next_visits(&mut self) -> Option<Look> {
        if let Some((_, Visit::Restore(number, _))) = self.visits.waiting.front() {
            let (number, save) = (*number, self.saves.get(*number).cloned());
            let (_, visit) = self.visits.waiting.pop_front()?;
            let Some(save) = save else {
                let name = format!("{} of {}", number, self.spec.name);
                visit.refuse(Fault::StateNotFound(name));
                return None;
            };
            self.visits.there = vec![visit];
            let retained = self.services.config.retained_results;
            return Some(Look::Back(Box::new(save), Ledger::new(retained)));
        }
        let is_look = |(_, visit): &(i64, Visit)| !matches!(visit, Visit::Restore(..));
        let mut look = Look::AtBytes;
        while self.is_visit_due() && self.visits.waiting.front().is_some_and(is_look) {
            let Some((_, visit)) = self.visits.waiting.pop_front() else {
                break;
            };
            if matches!(visit, Visit::Save(_)) {
                look = Look::AtAll;
            }
            self.visits.there.push(visit);
        }
        Some(look)
    }

    fn send_state(&self, mut work: Box<Work>, look: Look) {
        let (events, held) = (self.events.clone(), Arc::clone(&self.spec.reservation));
        let is_from_rest = self.path.is_from_rest();
        self.services.solvers.submit(
            self.client.flow(self.number),
            Length::Short,
            move |_| {
                let mut sight = look.at(&mut work);
                if let (true, Ok(sight)) = (is_from_rest, &mut sight) {
                    let rest = Session::at_rest(work.session.plan());
                    sight.start = Some(rest.into());
                }
                drop(held);
                (work, sight)
            },
            move |outcome| {
                // A session that is gone needs no state.
                let _gone = events.send(Event::Exported(outcome));
            },
        );
    }

    pub(super) fn exported(&mut self, outcome: Result<Exported, Panicked>) {
        let there = std::mem::take(&mut self.visits.there);
        let (mut work, sight) = match outcome {
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
        match sight {
            Ok(sight) => self.visited(there, sight),
            Err(why) => there
                .into_iter()
                .for_each(|visit| visit.refuse(why.clone())),
        }
    }

    /// Answers who was there, keeps the state where somebody wants that, and goes on from
    /// another one where it is there.
    fn visited(&mut self, there: Vec<Visit>, mut sight: Sight) {
        if let Some(rest) = sight.start.take() {
            self.path.start_at(rest);
        }
        for visit in there {
            let visited = match visit {
                Visit::Export(reply) => Visited::Exported(reply, self.path.save()),
                Visit::Restore(number, reply) => {
                    self.gone_back(number, &sight);
                    Visited::Restored(reply)
                }
                Visit::Save(reply) => match self.save(&sight) {
                    Ok(saved) => Visited::Saved(reply, saved),
                    Err(why) => {
                        answer(reply, Err(why));
                        continue;
                    }
                },
            };
            // When the disk has all that led there.
            self.visits.done.push((self.log.submitted(), visited));
        }
        self.account();
        self.answer_exports();
    }

    /// The state is that of a saved one.
    fn gone_back(&mut self, number: i64, sight: &Sight) {
        let Some(save) = self.saves.get(number) else {
            return;
        };
        let stored = save.stored.clone();
        self.path = Path::of(&stored);
        let retained = self.services.config.retained_results;
        let ledger = sight.ledger.unwrap_or_else(|| Ledger::new(retained));
        self.log.go_back(self.last_event, ledger);
        if let Some(copy) = &sight.copy {
            self.saves.note(number, sight.ledger, Arc::clone(copy));
        }
        let checkpoint = StoredCheckpoint {
            event: self.last_event,
            sequence: self.last_finished,
            done: 0,
            state: stored.state,
            since: stored.since,
        };
        self.record(vec![Change::Checkpoint(checkpoint)], Urgency::Now);
    }

    /// Keeps a state, if there is memory for it; its number and its bytes.
    fn save(&mut self, sight: &Sight) -> Result<(i64, u64), Fault> {
        let mut save = Save {
            stored: self.path.save(),
            ledger: Some(self.log.ledger()),
            copy: sight.copy.clone(),
        };
        let held = self.held_bytes();
        let after = |saves: &Saves, save: &Save| held - saves.bytes() + saves.bytes_with(save);
        let mut reservation = lock(&self.spec.reservation);
        if reservation.resize(after(&self.saves, &save)).is_err() {
            // What leads there is enough: going back takes longer.
            save.copy = None;
            let more = after(&self.saves, &save);
            let grown = reservation.resize(more);
            grown.map_err(|lacking| Fault::MemoryBudget {
                predicted: save.stored_bytes(),
                held,
                budget: more.saturating_sub(lacking),
            })?;
        }
        drop(reservation);
        let (stored, bytes) = (save.stored.clone(), save.stored_bytes());
        let number = self.saves.keep(save);
        let first = Change::DropSaves(self.saves.first());
        self.record(vec![Change::Save(number, stored), first], Urgency::Now);
        Ok((number, bytes))
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
