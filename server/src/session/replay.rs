//! The way back to a state: from a checkpoint, or the beginning, through the updates
//! that were accepted since, with the same bits as the first time.
//!
//! A checkpoint makes the solver forget what it has learnt, on which later bits depend.
//! So where one is due follows from what increments took, by counts that are the same in
//! every run: a replay is where the first run was. A session without a journal forgets at the
//! same increments, so that results do not depend on whether there is one.

use std::sync::Arc;
use std::time::Instant;

use signorini::mesh::Mesh;
use signorini::plan::Plan;
use signorini::prepare::Prepared;
use signorini::report::{CancelToken, Silent, StepReport, Termination};
use signorini::scene::{SceneError, Step};
use signorini::{CheckpointError, Reuse, Rounding, Session, StepRun};
use signorini_proto::v1 as wire;

use crate::convert::report;
use crate::journal::StoredCheckpoint;

/// What a replay may cost: about three quarters of a second on one core of 2020.
const MOST_COST: f64 = 1.5e7;
/// What a quadratic program costs beside its Krylov iterations, in applications of
/// the preconditioner.
const PROGRAM_COST: f64 = 20.0;
/// Results after a checkpoint, at most: those that a replay needs are kept.
const MOST_RESULTS: usize = 1024;

/// What doing an increment again would take: unknowns times passes over them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cost(f64);

impl Cost {
    /// By counts alone, so that it is the same in every run.
    pub(super) fn of(report: &StepReport) -> Self {
        let applications = f64::from(report.preconditioner_applications);
        let programs = f64::from(report.sqp_iterations);
        let unknowns = report.unknowns.displacement as f64;
        Self(unknowns * (applications + PROGRAM_COST * programs))
    }
}

/// What a replay would have to do again.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ledger {
    cost: f64,
    results: usize,
    most_results: usize,
}

impl Ledger {
    /// Nothing yet, for a session that keeps so many results.
    pub(super) fn new(retained_results: usize) -> Self {
        Self {
            cost: 0.0,
            results: 0,
            most_results: retained_results.min(MOST_RESULTS),
        }
    }

    /// Whether a checkpoint is due after an increment.
    pub(super) fn is_due(&self, next: &Cost, termination: Termination) -> bool {
        match termination {
            // How far it came before its time was up, no replay finds again.
            Termination::DeadlineExceeded => true,
            // No replay repeats it.
            Termination::Cancelled | Termination::InternalError => false,
            Termination::Converged | Termination::NotConverged => {
                self.cost + next.0 > MOST_COST || self.results + 1 >= self.most_results
            }
        }
    }

    /// Counts a result, with a checkpoint after it or not; one that was stopped takes
    /// nothing.
    pub(super) fn count(&mut self, cost: Cost, is_checkpoint: bool) {
        if is_checkpoint {
            *self = Self::new(self.most_results)
        } else {
            self.cost += cost.0;
            self.results += 1;
        }
    }
}

/// What a session stands on.
pub(super) struct Ground {
    pub(super) plan: Arc<Plan>,
    pub(super) mesh: Arc<Mesh>,
    pub(super) prepared: Arc<Prepared>,
    pub(super) reuse: Reuse,
}

impl Ground {
    pub(super) fn session(self) -> Session {
        Session::new(self.plan, self.mesh, self.prepared, self.reuse)
    }

    /// The session of a checkpoint, and whether another instruction set rounded it.
    fn import(self, bytes: &[u8]) -> Result<(Session, bool), CheckpointError> {
        let is_foreign = Session::check_import(&self.plan, bytes, Rounding::Same).is_err();
        let session =
            Session::import_rounded(self.plan, self.mesh, self.prepared, self.reuse, bytes);
        Ok((session?, is_foreign))
    }
}

/// Why a session does not come back.
#[derive(Debug, thiserror::Error)]
pub(super) enum ReplayError {
    #[error(transparent)]
    State(#[from] CheckpointError),
    #[error("update {sequence} is refused when it is replayed: {why}")]
    Refused { sequence: i64, why: SceneError },
    #[error("update {0} ends in another way when it is replayed")]
    Differs(i64),
}

/// An update to do again.
pub(super) struct ReplayStep {
    pub(super) sequence: i64,
    pub(super) step: Step,
    /// Increments that the checkpoint has already.
    pub(super) before: u32,
    /// Results after the checkpoint, with their events.
    pub(super) results: Vec<(i64, wire::StepReport)>,
    /// Whether the last of them ended the update.
    pub(super) is_finished: bool,
}

/// What an earlier server did in a session.
pub(super) struct Replay {
    pub(super) checkpoint: Option<StoredCheckpoint>,
    pub(super) steps: Vec<ReplayStep>,
    pub(super) ledger: Ledger,
    pub(super) cancel: CancelToken,
}

/// What a replay did.
#[derive(Debug, Default)]
pub(super) struct Replayed {
    pub(super) increments: u32,
    pub(super) seconds: f64,
    /// Results that differ from those of the first run.
    pub(super) differing: u32,
    pub(super) ledger: Option<Ledger>,
    /// Another instruction set wrote the checkpoint.
    pub(super) is_foreign: bool,
    /// The newest state that was due for the journal.
    pub(super) checkpoint: Option<StoredCheckpoint>,
}

/// The report under the number of its update: the library counts the steps that
/// began, and does not know of those that stopped before.
pub(super) fn numbered(report: StepReport, step: u32) -> StepReport {
    StepReport {
        time: report.time + (f64::from(step) - f64::from(report.step)),
        step,
        ..report
    }
}

impl Replay {
    /// Goes the way; the session, with the step that is under way.
    pub(super) fn run(
        self,
        ground: Ground,
    ) -> Result<(Session, Option<StepRun>, Replayed), ReplayError> {
        let start = Instant::now();
        let (mut session, is_foreign) = match &self.checkpoint {
            Some(checkpoint) => ground.import(&checkpoint.state)?,
            None => (ground.session(), false),
        };
        let mut way = Way {
            replayed: Replayed {
                ledger: Some(self.ledger),
                is_foreign,
                ..Replayed::default()
            },
            cancel: self.cancel,
        };
        let mut run = None;
        for step in &self.steps {
            run = way.step(&mut session, step)?;
        }
        let mut replayed = way.replayed;
        replayed.seconds = start.elapsed().as_secs_f64();
        Ok((session, run, replayed))
    }
}

struct Way {
    replayed: Replayed,
    cancel: CancelToken,
}

impl Way {
    /// Does one update as far as it came; its rest, if there is one.
    fn step(
        &mut self,
        session: &mut Session,
        step: &ReplayStep,
    ) -> Result<Option<StepRun>, ReplayError> {
        let stopped = step.results.last().filter(|(_, last)| is_stopped(last));
        let again = step.results.len() - usize::from(stopped.is_some());
        let mut run = None;
        // One that was stopped before it began may never have been checked.
        if step.before > 0 || again > 0 {
            let mut begun = begin(session, step)?;
            for (event, first) in step.results.iter().take(again) {
                self.increment(session, &mut begun, (step, *event), first)?;
            }
            run = Some(begun);
        }
        if stopped.is_some() {
            session.stop();
            if let Some(ledger) = &mut self.replayed.ledger {
                ledger.count(Cost::default(), false);
            }
        }
        Ok(run.filter(|_| !step.is_finished))
    }

    fn increment(
        &mut self,
        session: &mut Session,
        run: &mut StepRun,
        (step, event): (&ReplayStep, i64),
        first: &wire::StepReport,
    ) -> Result<(), ReplayError> {
        let differs = || ReplayError::Differs(step.sequence);
        let done = session.advance(run, &mut Silent, &self.cancel);
        let done = done.ok_or_else(differs)?;
        let (cost, termination) = (Cost::of(&done), done.termination);
        let number = u32::try_from(step.sequence).unwrap_or(u32::MAX);
        let again = report::step(numbered(done, number), session.obstacle_poses());
        if again.termination != first.termination {
            return Err(differs());
        }
        self.replayed.increments += 1;
        self.replayed.differing += u32::from(bare(again) != bare(first.clone()));
        let due = self
            .replayed
            .ledger
            .map(|one| one.is_due(&cost, termination));
        if due == Some(true) {
            let is_last = step.is_finished && step.results.last().is_some_and(|one| one.0 == event);
            self.replayed.checkpoint = Some(StoredCheckpoint {
                event,
                sequence: step.sequence,
                done: if is_last { 0 } else { run.done() },
                state: session.export().into(),
            });
        }
        if let Some(ledger) = &mut self.replayed.ledger {
            ledger.count(cost, due == Some(true));
        }
        Ok(())
    }
}

/// Begins an update, or goes on with one from the middle.
fn begin(session: &mut Session, step: &ReplayStep) -> Result<StepRun, ReplayError> {
    let sequence = step.sequence;
    match step.before {
        0 => session
            .begin_step(&step.step)
            .map_err(|why| ReplayError::Refused { sequence, why }),
        done => session
            .resume_step(step.step.increments, done)
            .ok_or(ReplayError::Differs(sequence)),
    }
}

/// Whether an increment was stopped: a replay ends before it.
fn is_stopped(report: &wire::StepReport) -> bool {
    match report.termination() {
        wire::Termination::Cancelled
        | wire::Termination::DeadlineExceeded
        | wire::Termination::InternalError => true,
        wire::Termination::Unspecified
        | wire::Termination::Converged
        | wire::Termination::NotConverged => false,
    }
}

/// A report without what a second run may do otherwise: times, memory, and what it
/// found prepared.
fn bare(report: wire::StepReport) -> wire::StepReport {
    wire::StepReport {
        seconds: None,
        memory_bytes: 0,
        reused: Vec::new(),
        factorisations: 0,
        eigenvalue_applications: 0,
        compliance_columns: 0,
        ..report
    }
}
