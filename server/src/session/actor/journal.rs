//! What a session writes into the journal and how it goes on from it.
//!
//! Every change has a number, its mark. A result is shown when the disk has it: what a client
//! has read is never made again, so nothing that happens after a kill can change it.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use super::results::Ending;
use super::saves::Saves;
use super::{Actor, answer};
use crate::convert::step::Update;
use crate::journal::{Change, JournalError, StoredCheckpoint, StoredUpdate, Urgency};
use crate::results::kept::KeptResult;
use crate::session::SessionEnd;
use crate::session::ledger::{Cost, Ledger};
use crate::session::recovered::{Recovered, stored};
use crate::session::replay::{self, Known, Replay, ReplayStep, Replayed};
use crate::session::work::Checkpoint;

/// Changes that may wait for the disk before the next increment waits.
const MOST_WAITING: u64 = 256;
/// Results are dropped from the disk in groups of so many.
const DROPPED_TOGETHER: i64 = 32;

/// How far the disk has what the session did.
pub(super) struct Log {
    is_kept: bool,
    /// Mark of the newest change.
    submitted: u64,
    /// Mark of the newest change that the disk has.
    pub(super) durable: u64,
    ledger: Ledger,
    /// Event of the newest checkpoint: results after it are needed.
    checkpoint: i64,
}

impl Log {
    pub(super) fn new(is_kept: bool, retained_results: usize) -> Self {
        Self {
            is_kept,
            submitted: 0,
            durable: if is_kept { 0 } else { u64::MAX },
            ledger: Ledger::new(retained_results),
            checkpoint: 0,
        }
    }

    pub(super) fn is_kept(&self) -> bool {
        self.is_kept
    }

    pub(super) fn ledger(&self) -> Ledger {
        self.ledger
    }

    /// Counts a result of that event.
    fn count(&mut self, event: i64, cost: Cost, is_checkpoint: bool) {
        self.ledger.count(cost, is_checkpoint);
        if is_checkpoint {
            self.checkpoint = event;
        }
    }

    /// Mark of the newest change.
    pub(super) fn submitted(&self) -> u64 {
        self.submitted
    }

    /// Another state is there, after that event, of which a replay would have to do so much.
    pub(super) fn go_back(&mut self, event: i64, ledger: Ledger) {
        self.checkpoint = event;
        self.ledger = ledger;
    }

    /// Whether the disk keeps up.
    pub(super) fn has_room(&self) -> bool {
        self.submitted.saturating_sub(self.durable) < MOST_WAITING
    }
}

impl Actor {
    /// Hands changes to the disk; their mark, 0 without a journal.
    pub(super) fn record(&mut self, changes: Vec<Change>, urgency: Urgency) -> u64 {
        use crate::session::work::Event;
        let Some(journal) = &self.services.journal else {
            return 0;
        };
        self.log.submitted += 1;
        let (mark, events) = (self.log.submitted, self.events.clone());
        let done = Box::new(move |outcome| {
            // A session that is over has what it needs.
            let _over = events.send(Event::Journalled(mark, outcome));
        });
        journal.submit(&self.spec.name, changes, urgency, done);
        mark
    }

    pub(super) fn log_update(&mut self, update: &Update) -> u64 {
        let stored = StoredUpdate {
            encoded: update.encoded.clone(),
            cancelled: false,
        };
        let change = Change::Update(update.sequence, stored);
        self.record(vec![change], Urgency::Now)
    }

    /// A step was asked to stop: it shall, after a kill too.
    pub(super) fn log_cancelled(&mut self, sequence: i64) {
        let Some(accepted) = self.queue.find(sequence) else {
            return;
        };
        let stored = StoredUpdate {
            encoded: accepted.encoded.clone(),
            cancelled: true,
        };
        self.record(vec![Change::Update(sequence, stored)], Urgency::Now);
    }

    /// Updates from `sequence` on have lost their place.
    pub(super) fn log_withdrawn(&mut self, sequence: i64) {
        if self.queue.find(sequence).is_some() {
            self.record(vec![Change::Withdraw(sequence)], Urgency::Soon);
        }
    }

    /// Writes a result; the mark that the disk has to have before it is shown.
    pub(super) fn log_result(&mut self, result: &KeptResult, ending: &Ending) -> u64 {
        let is_checkpoint = ending.checkpoint.is_some();
        self.log.count(result.event, ending.cost, is_checkpoint);
        if !self.log.is_kept {
            return 0;
        }
        let (report, fields) = stored(result, unix_seconds());
        let mut changes = vec![Change::Result(result.event, report, fields)];
        if let Some(Checkpoint::Written(state)) = &ending.checkpoint {
            let done = u32::try_from(result.report.increment).unwrap_or_default();
            changes.push(Change::Checkpoint(StoredCheckpoint {
                event: result.event,
                sequence: result.sequence,
                done: if result.last { 0 } else { done },
                state: state.clone(),
                since: Vec::new(),
            }));
        }
        changes.extend(self.outdated(result.event));
        self.record(changes, Urgency::Now)
    }

    /// What need no longer be kept on disk now and then.
    fn outdated(&self, event: i64) -> Vec<Change> {
        if event % DROPPED_TOGETHER != 0 {
            return Vec::new();
        }
        let retained = self.services.config.retained_results;
        let first = event + 1 - i64::try_from(retained).unwrap_or(i64::MAX);
        let first = first.min(self.log.checkpoint + 1);
        let results = (first > 1).then_some(Change::DropResults(first));
        let fields = self.kept.first_with_fields().map(Change::DropFields);
        results.into_iter().chain(fields).collect()
    }

    /// The disk has the changes up to `mark`, or refuses them.
    pub(super) fn journalled(&mut self, mark: u64, outcome: Result<(), JournalError>) {
        match outcome {
            // Stored under a lease that has ended since: the next holder tells of it.
            Ok(()) if self.is_given_up() => {}
            Ok(()) => {
                self.log.durable = self.log.durable.max(mark);
                self.kept.show(self.log.durable);
                let fresh = self.fresh.take();
                self.feed(fresh.as_ref());
                self.fresh = fresh;
                self.answer_exports();
            }
            Err(why) => self.end(SessionEnd::Interrupted(Some(why))),
        }
    }

    /// Takes over what the journal knows; what is to be done again.
    pub(super) fn recover(&mut self) -> Option<Box<Replay>> {
        let Recovered {
            updates,
            results,
            checkpoint,
            since,
            saves,
        } = *self.spec.recovered.take()?;
        self.saves = Saves::new(saves);
        let checkpointed = checkpoint.as_ref().map_or(0, |one| one.event);
        self.log.checkpoint = checkpointed;
        let mut first: BTreeMap<i64, Vec<_>> = BTreeMap::new();
        for result in results {
            let result = self.kept.push(result);
            if result.event > checkpointed {
                let of_update = first.entry(result.sequence).or_default();
                of_update.push(result);
            }
        }
        if let Some(newest) = self.kept.newest() {
            self.last_event = newest.event;
            self.last_finished = newest.sequence - i64::from(!newest.last);
            self.last_report = newest.report.decode();
        }
        self.queue.resume_after(self.last_finished);
        let mut steps = Vec::new();
        for (update, is_cancelled) in updates {
            let sequence = update.sequence;
            let results = first.remove(&sequence).unwrap_or_default();
            let step = replay_step(&update, results, checkpoint.as_ref());
            steps.extend(step.filter(|one| one.before > 0 || one.done > 0 || one.is_stopped));
            if sequence > self.last_finished {
                let newest = self.kept.of_sequence(sequence).pop();
                let results = newest.map_or(0, |newest| newest.report.increment);
                if let Some(accepted) = self.queue.push(update) {
                    accepted.results = u32::try_from(results).unwrap_or_default();
                    if is_cancelled {
                        accepted.cancel();
                    }
                }
            }
        }
        if let (Some(last), Some(newest)) = (last_known(&mut steps), self.kept.newest()) {
            last.fields = newest.fields_at(last.event);
        }
        Some(Box::new(Replay {
            checkpoint,
            since,
            steps,
            ledger: self.log.ledger,
            cancel: self.stop_preparing.clone(),
        }))
    }

    /// The state is where an earlier server left it.
    pub(super) fn replayed(&mut self, replayed: Replayed) {
        // What was stopped meanwhile was stopped after that.
        let meanwhile = std::mem::replace(&mut self.path, replayed.path);
        self.path.append(meanwhile);
        let Some(ledger) = replayed.ledger else {
            return;
        };
        self.log.ledger = ledger;
        let differing = replayed.differing.len();
        self.services.metrics.replay(replayed.seconds);
        self.services.metrics.replay_differences(differing);
        tracing::info!(
            increments = replayed.increments,
            seconds = replayed.seconds,
            differing,
            finished = self.last_finished,
            waiting = self.queue.len(),
            "session resumed"
        );
        if replayed.is_foreign {
            tracing::warn!(
                "the state was rounded by another instruction set: results are the same up to rounding"
            );
        }
        if let Some(first) = replayed.differing.first() {
            tracing::error!(
                first,
                differing,
                "a replay gave other results than the first run; those that were sent stay"
            );
        }
        if let Some(checkpoint) = replayed.checkpoint {
            self.log.checkpoint = checkpoint.event;
            self.record(vec![Change::Checkpoint(checkpoint)], Urgency::Soon);
        }
    }

    /// Leaves everything to the journal: nothing is answered that is not answered yet.
    pub(super) fn interrupt(&mut self) {
        if let Some(current) = self.queue.current() {
            current.cancel();
        }
        self.queue.refuse();
    }

    /// Drops a session from the disk that does not go on, and tells those who asked.
    pub(super) async fn forget_stored(&mut self, ending: &SessionEnd) {
        if let Some(journal) = self
            .services
            .journal
            .clone()
            .filter(|_| !ending.is_interruption())
            && let Err(why) = journal.store(&self.spec.name, vec![Change::Delete]).await
        {
            tracing::error!(why = why.to_string(), "a session stays on disk");
        }
        for deleter in self.deleters.drain(..) {
            answer(deleter, ());
        }
    }
}

/// What an earlier server did in an update, after the checkpoint; none where there is no place
/// for it.
fn replay_step(
    update: &Update,
    results: Vec<Arc<KeptResult>>,
    checkpoint: Option<&StoredCheckpoint>,
) -> Option<ReplayStep> {
    let under_way = checkpoint.filter(|one| one.sequence == update.sequence);
    let is_finished = results.last().is_some_and(|newest| newest.last);
    let mut known = Vec::with_capacity(results.len());
    let mut is_stopped = false;
    for result in results {
        let report = result.report.decode()?;
        is_stopped = replay::is_stopped(&report);
        known.push(Known {
            event: result.event,
            report,
            fields: Vec::new(),
        });
    }
    if is_stopped {
        known.pop();
    }
    Some(ReplayStep {
        update: update.clone(),
        before: under_way.map_or(0, |one| one.done),
        done: u32::try_from(known.len()).ok()?,
        is_stopped,
        known,
        is_finished,
    })
}

/// The newest result that is compared.
fn last_known(steps: &mut [ReplayStep]) -> Option<&mut Known> {
    steps
        .iter_mut()
        .rev()
        .find_map(|step| step.known.last_mut())
}

fn unix_seconds() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |since| since.as_secs().cast_signed())
}
