//! What a session does on a solver thread: preparation and increments.

mod preparing;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bytes::Bytes;
use signorini::report::{
    CancelToken, FieldName, IterationRecord, Observer, StepReport, Termination,
};
use signorini::scene::{SceneError, Step};
use signorini::{ObstaclePose, Session, Snapshot, StepRun};

use super::clock::SlotClock;
use super::ledger::{Cost, Ledger};
use super::replay::numbered;
use crate::compute::{Panicked, Slot, said};
use crate::convert::field::KeptField;
use crate::convert::report;
use crate::fault::Fault;
use crate::journal::JournalError;
use crate::process::memory;
use crate::results::iterations::Iterations;
use crate::results::unfinished;
use crate::watch::metrics::Metrics;
use crate::watch::traces::{IncrementTrace, UpdateTrace};
pub(super) use preparing::{Preparation, Ready, Unprepared, length, prepare};

/// The state of a session with the step under way; where it is, nobody else is.
pub(super) struct Work {
    pub(super) session: Session,
    pub(super) run: Option<StepRun>,
}

impl Work {
    /// Forgets the step under way, which has ended by itself.
    pub(super) fn forget(&mut self) {
        self.run = None;
    }

    /// Stops the step under way, begun or not; the state stays as the last
    /// increment left it.
    pub(super) fn stop(&mut self) {
        self.session.stop();
        self.forget();
    }

    /// Undoes the last increment and stops its step.
    pub(super) fn take_back(&mut self) {
        self.session.take_back();
        self.forget();
    }
}

/// The state, and what a solver thread did with it.
pub(super) type Exported = (Box<Work>, Result<Sight, Fault>);

/// What was seen of a state, or of the saved one that has taken its place.
#[derive(Default)]
pub(super) struct Sight {
    /// The state at rest, where the path to this one begins there.
    pub(super) start: Option<Bytes>,
    /// A copy, where one is kept.
    pub(super) copy: Option<Arc<Snapshot>>,
    /// What a replay would have to do again, of a saved one.
    pub(super) ledger: Option<Ledger>,
}

/// A session's state between its actor and a solver thread; whoever takes it
/// first has it.
pub(super) type Handoff = Arc<Mutex<Option<Box<Work>>>>;

/// Takes what is in a handoff.
pub(super) fn take(handoff: &Handoff) -> Option<Box<Work>> {
    handoff
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .take()
}

/// One increment to do.
pub(super) struct Task {
    pub(super) sequence: i64,
    /// Number of the step, from 1.
    pub(super) number: u32,
    pub(super) step: Step,
    pub(super) cancel: CancelToken,
    /// Time that the step had a slot.
    pub(super) clock: Arc<SlotClock>,
    pub(super) wanted: Vec<FieldName>,
    /// Fields come with every n-th increment and the last of the step.
    pub(super) every: u32,
    /// Memory that the increment may have to allocate.
    pub(super) scratch_bytes: u64,
    /// Results finished so far.
    pub(super) after_event: i64,
    pub(super) iterations: Iterations,
    pub(super) metrics: Arc<Metrics>,
    pub(super) trace: UpdateTrace,
    /// What a replay would have to do again so far, with a journal or not.
    pub(super) ledger: Ledger,
    /// Whether there is a journal.
    pub(super) is_kept: bool,
}

/// How far a session is from the response of its body, which takes memory of its own.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ResponseProgress {
    /// Steps begun, those before an import included.
    pub(super) steps: u32,
    /// It is there and counted, or does not fit.
    pub(super) is_tried: bool,
}

impl ResponseProgress {
    fn of(session: &Session) -> Self {
        Self {
            steps: session.steps(),
            is_tried: session.has_tried_response(),
        }
    }
}

/// One increment done.
pub(super) struct Increment {
    pub(super) report: StepReport,
    pub(super) poses: Vec<ObstaclePose>,
    /// Fields that were due, of which the scene may lack some; `None` when none was.
    pub(super) asked: Option<Vec<FieldName>>,
    pub(super) fields: Vec<KeptField>,
    pub(super) state_bytes: u64,
    pub(super) response: ResponseProgress,
    /// What doing it again would take.
    pub(super) cost: Cost,
    /// Where a checkpoint was due.
    pub(super) checkpoint: Option<Checkpoint>,
}

/// The solver has forgotten what it had learnt, so that a session that goes on from here has the
/// same bits.
pub(super) enum Checkpoint {
    /// The state, for the journal.
    Written(Bytes),
    /// There is no journal: results shall not depend on that.
    Passed(Bytes),
}

/// How a task ended.
pub(super) enum Outcome {
    /// The actor took the state back before the task began.
    Withdrawn,
    /// The step is faulty; the state is as before.
    Refused(Box<Work>, SceneError),
    Increment(Box<Work>, Box<Increment>),
    /// A defect or no memory; the state is as before the increment.
    Broken(Box<Work>, String),
}

/// What solver threads and clocks tell an actor.
pub(super) enum Event {
    Prepared(Result<Box<Ready>, Unprepared>),
    Advanced(Result<Outcome, Panicked>),
    /// The time of this sequence is up.
    Deadline(i64),
    /// This sequence had a slot as long as any step may.
    Ceiling(i64),
    /// This sequence was told to stop long enough ago.
    OutOfPatience(i64),
    /// This sequence was left behind long enough ago.
    Stuck(i64),
    /// The state was looked at, or another one is in its place.
    Exported(Result<Exported, Panicked>),
    /// The disk has the changes up to this one, or will not get it.
    Journalled(u64, Result<(), JournalError>),
}

/// Does the next increment of a task.
pub(super) fn advance(handoff: &Handoff, task: &Task, slot: &Slot) -> Outcome {
    let Some(mut work) = take(handoff) else {
        return Outcome::Withdrawn;
    };
    let _span = tracing::info_span!("step", sequence = task.sequence).entered();
    let _running = task.clock.run();
    let run = match work.run.take() {
        Some(run) => run,
        None => match work.session.begin_step(&task.step) {
            Ok(run) => run,
            Err(error) => return Outcome::Refused(work, error),
        },
    };
    if let Err(error) = memory::probe(task.scratch_bytes) {
        return Outcome::Broken(work, error.to_string());
    }
    match catch_unwind(AssertUnwindSafe(|| increment(&mut work, run, task, slot))) {
        Ok(increment) => Outcome::Increment(work, Box::new(increment)),
        Err(payload) => {
            // Only the session is used again, and it goes back to its last state.
            work.take_back();
            Outcome::Broken(work, said(payload.as_ref()))
        }
    }
}

fn increment(work: &mut Work, mut run: StepRun, task: &Task, slot: &Slot) -> Increment {
    let mut reporter = Reporter {
        task,
        slot,
        paused: Duration::ZERO,
        trace: task.trace.increment(run.done() + 1),
    };
    let done = work.session.advance(&mut run, &mut reporter, &task.cancel);
    let paused = reporter.paused.as_secs_f64();
    let report = match done {
        Some(report) => numbered(without(report, paused), task.number),
        // Only a step that is finished has no further increment.
        None => unfinished::report(task.number, run.done(), Termination::InternalError),
    };
    reporter.trace.finish(&report);
    let cost = Cost::of(&report);
    let is_time = task.ledger.is_due(&cost, report.termination);
    // A thread that is left behind has to undo the increment.
    let is_done = task.cancel.stopped().is_none();
    let is_out_of_time = report.termination == Termination::DeadlineExceeded;
    let checkpoint =
        (is_time && (is_done || is_out_of_time)).then(|| checkpoint(&mut work.session, task));
    work.run = Some(run);
    let asked = is_due(&report, task).then(|| task.wanted.clone());
    if asked.as_ref().is_some_and(|asked| !asked.is_empty()) {
        work.session.complete();
    }
    Increment {
        report,
        poses: work.session.obstacle_poses(),
        fields: gather(&work.session, asked.as_deref().unwrap_or_default()),
        asked,
        state_bytes: work.session.bytes(),
        response: ResponseProgress::of(&work.session),
        cost,
        checkpoint,
    }
}

fn checkpoint(session: &mut Session, task: &Task) -> Checkpoint {
    if task.is_kept {
        Checkpoint::Written(session.export().into())
    } else {
        session.forget();
        Checkpoint::Passed(session.to_bytes().into())
    }
}

/// The report without the time in which its solve had no slot.
fn without(mut report: StepReport, paused: f64) -> StepReport {
    // Iterations are reported from inside the Krylov method.
    for seconds in [&mut report.seconds.total, &mut report.seconds.krylov] {
        *seconds = (*seconds - paused).max(0.0);
    }
    report
}

fn is_due(report: &StepReport, task: &Task) -> bool {
    report.ends_step(task.step.increments) || report.increment.is_multiple_of(task.every)
}

fn gather(session: &Session, wanted: &[FieldName]) -> Vec<KeptField> {
    let found = wanted.iter().filter_map(|name| session.field(*name));
    found.map(|field| KeptField::new(&field)).collect()
}

/// Turns iterations into messages and metrics.
struct Reporter<'a> {
    task: &'a Task,
    slot: &'a Slot,
    /// Time in which others had the slot.
    paused: Duration,
    trace: IncrementTrace,
}

impl Observer for Reporter<'_> {
    fn iteration(&mut self, record: &IterationRecord) {
        fail::fail_point!("iteration");
        self.task.metrics.iteration();
        self.trace.iteration(record);
        self.slot.show_residual(record.residuals.largest());
        let report = report::iteration(&IterationRecord {
            step: self.task.number,
            ..record.clone()
        });
        let (sequence, after) = (self.task.sequence, self.task.after_event);
        self.task.iterations.publish(sequence, after, report);
        let cancel = &self.task.cancel;
        let is_stopped = || cancel.stopped().is_some();
        let clock = &self.task.clock;
        self.paused += clock.without(|| self.slot.pause(&is_stopped));
    }
}
