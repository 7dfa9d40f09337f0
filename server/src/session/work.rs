//! What a session does on a solver thread: preparation and increments.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bytes::Bytes;
use signorini::mesh::Mesh;
use signorini::plan::Plan;
use signorini::prepare::{PrepareError, Prepared};
use signorini::report::{
    CancelToken, FieldName, IterationRecord, Observer, StepReport, Termination,
};
use signorini::scene::{SceneError, Step};
use signorini::{ObstaclePose, Reuse, Session, StepRun};
use tokio::sync::{mpsc, oneshot};

use super::Services;
use super::clock::SlotClock;
use super::replay::{Cost, Ground, Ledger, Replay, ReplayError, Replayed, numbered};
use crate::client_key::Flow;
use crate::compute::{Length, Panicked, Slot, said};
use crate::convert::field::KeptField;
use crate::convert::report;
use crate::fault::{FailureCause, Fault};
use crate::journal::JournalError;
use crate::memory::{self, OutOfMemory};
use crate::metrics::Metrics;
use crate::results::iterations::Iterations;
use crate::results::unfinished;
use crate::store::{Lease, Reservation};
use crate::traces::{IncrementTrace, UpdateTrace};

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

/// The state, and what a solver thread made of it: its bytes.
pub(super) type Exported = (Box<Work>, Result<Bytes, Fault>);

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
    /// What a replay would have to do again so far; none where there is no journal.
    pub(super) ledger: Option<Ledger>,
}

/// One increment done.
pub(super) struct Increment {
    pub(super) report: StepReport,
    pub(super) poses: Vec<ObstaclePose>,
    /// Fields that were due, of which the scene may lack some; `None` when none was.
    pub(super) asked: Option<Vec<FieldName>>,
    pub(super) fields: Vec<KeptField>,
    pub(super) state_bytes: u64,
    /// What doing it again would take.
    pub(super) cost: Cost,
    /// The state behind it, where the journal shall have it.
    pub(super) checkpoint: Option<Vec<u8>>,
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
    /// The state as bytes, with the session that goes on without what it had learnt.
    Exported(Result<Exported, Panicked>),
    /// The disk has the changes up to this one, or will not get it.
    Journalled(u64, Result<(), JournalError>),
}

/// A session that can step.
pub(super) struct Ready {
    pub(super) work: Box<Work>,
    pub(super) prepared: Lease<Prepared>,
    pub(super) reuse: Reuse,
    pub(super) state_bytes: u64,
    pub(super) replayed: Replayed,
}

/// Why a session cannot step.
#[derive(Debug, thiserror::Error)]
pub(super) enum Unprepared {
    #[error(transparent)]
    Failed(#[from] PrepareError),
    #[error(transparent)]
    Memory(#[from] OutOfMemory),
    #[error("a defect of the server; its log says more")]
    Panicked(#[from] Panicked),
    #[error("the server is shutting down")]
    Closed,
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

impl Unprepared {
    pub(super) fn cause(&self) -> FailureCause {
        match self {
            Self::Memory(_) => FailureCause::Memory,
            Self::Failed(_) | Self::Panicked(_) | Self::Closed | Self::Replay(_) => {
                FailureCause::Other
            }
        }
    }
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
    let is_time = task
        .ledger
        .is_some_and(|ledger| ledger.is_due(&cost, report.termination));
    // A thread that is left behind has to undo the increment.
    let is_done = task.cancel.stopped().is_none();
    let is_out_of_time = report.termination == Termination::DeadlineExceeded;
    let checkpoint = (is_time && (is_done || is_out_of_time)).then(|| work.session.export());
    work.run = Some(run);
    let asked = is_due(&report, task).then(|| task.wanted.clone());
    Increment {
        report,
        poses: work.session.obstacle_poses(),
        fields: gather(&work.session, asked.as_deref().unwrap_or_default()),
        asked,
        state_bytes: work.session.bytes(),
        cost,
        checkpoint,
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
    let last = report.increment >= task.step.increments;
    last || report.termination != Termination::Converged
        || report.increment.is_multiple_of(task.every)
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

/// Unknowns from which a body is long work before anything of it has run: some 0.3 s
/// a factorisation on one core.
const LONG_UNKNOWNS: u64 = 60_000;

/// Whether work on a plan is long, as far as its size tells.
pub(super) fn length(plan: &Plan) -> Length {
    match plan.report().unknowns.displacement < LONG_UNKNOWNS {
        true => Length::Short,
        false => Length::Long,
    }
}

/// What [`prepare`] builds from.
pub(super) struct Preparation {
    pub(super) plan: Arc<Plan>,
    pub(super) mesh: Arc<Mesh>,
    /// Whose share it uses.
    pub(super) flow: Flow,
    pub(super) cancel: CancelToken,
    /// Held as long as the work may hold memory.
    pub(super) reservation: Arc<Mutex<Reservation>>,
    /// What an earlier server did in this session.
    pub(super) replay: Option<Box<Replay>>,
}

/// Builds what the plan needs, or finds it, and tells the actor.
pub(super) async fn prepare(
    services: Arc<Services>,
    preparation: Preparation,
    events: mpsc::UnboundedSender<Event>,
) {
    let outcome = ready(&services, preparation).await;
    // A session that is gone needs nothing.
    let _gone = events.send(Event::Prepared(outcome.map(Box::new)));
}

async fn ready(services: &Arc<Services>, preparation: Preparation) -> Result<Ready, Unprepared> {
    let Preparation {
        plan,
        mesh,
        flow,
        cancel,
        reservation,
        replay,
    } = preparation;
    let turn = services.store.turn(plan.key());
    let guard = turn.lock().await;
    let (prepared, reuse) = match services.store.prepared(&plan.key()) {
        Some(lease) => (lease, Reuse::Reused),
        None => {
            memory::probe(plan.report().predicted_bytes)?;
            let (for_build, on) = (Arc::clone(&plan), Arc::clone(&mesh));
            let held = Arc::clone(&reservation);
            let build = move || {
                let built = Prepared::build(&for_build, &on, &cancel);
                drop(held);
                built
            };
            let length = length(&plan);
            let built = on_solver(services, flow, length, build).await??;
            (
                services.store.insert_prepared(plan.key(), mesh.id(), built),
                Reuse::Built,
            )
        }
    };
    drop(guard);
    let shared = Arc::clone(prepared.value());
    let ground = Ground {
        plan,
        mesh,
        prepared: shared,
        reuse,
    };
    let length = match &replay {
        None => Length::Short,
        Some(_) => Length::Long,
    };
    let begin = move || match replay {
        None => Ok((ground.session(), None, Replayed::default())),
        Some(replay) => (*replay).run(ground),
    };
    let (session, run, replayed) = on_solver(services, flow, length, begin).await??;
    drop(reservation);
    Ok(Ready {
        state_bytes: session.bytes(),
        work: Box::new(Work { session, run }),
        prepared,
        reuse,
        replayed,
    })
}

async fn on_solver<T: Send + 'static>(
    services: &Services,
    flow: Flow,
    length: Length,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Unprepared> {
    let (sender, receiver) = oneshot::channel();
    services.solvers.submit(
        flow,
        length,
        |_| work(),
        move |outcome| {
            // The session may be gone; its value is dropped then.
            let _gone = sender.send(outcome);
        },
    );
    let outcome = receiver.await.map_err(|_| Unprepared::Closed)?;
    if let Err(Panicked(said)) = &outcome {
        tracing::error!(said, "preparation panicked");
    }
    Ok(outcome?)
}
