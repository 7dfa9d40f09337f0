//! The way back to a state: from a checkpoint, or the beginning, through the updates
//! that were accepted since, with the same bits as the first time.
//!
//! Every result that was sent is in the journal, so a replay makes none again: it compares.
//!
//! A checkpoint makes the solver forget what it has learnt, on which later bits depend.
//! So where one is due follows from what increments took, by counts that are the same in
//! every run: a replay is where the first run was. A session without a journal forgets at the
//! same increments, so that results do not depend on whether there is one.

use std::sync::Arc;
use std::time::Instant;

use bytes::Bytes;
use prost::Message as _;
use signorini::mesh::Mesh;
use signorini::plan::Plan;
use signorini::prepare::Prepared;
use signorini::report::{CancelToken, Silent, StepReport};
use signorini::scene::SceneError;
use signorini::{CheckpointError, Reuse, Rounding, Session, StepRun};
use signorini_proto::v1::{self as wire, solve_request};

use super::ledger::{Cost, Ledger, MOST_RESULTS};
use super::path::{Passage, Path};
use crate::convert::field::KeptField;
use crate::convert::report;
use crate::convert::step::{self as steps, Update};
use crate::journal::{StoredCheckpoint, StoredSave, StoredWork};

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
    #[error("what was done on the state cannot be read")]
    Unreadable,
}

impl ReplayError {
    /// Whether something came out otherwise than in the first run.
    pub(super) fn is_difference(&self) -> bool {
        match self {
            Self::Refused { .. } | Self::Differs(_) => true,
            Self::State(_) | Self::Unreadable => false,
        }
    }
}

/// A result of the first run, as the journal has it.
pub(super) struct Known {
    pub(super) event: i64,
    pub(super) report: wire::StepReport,
    /// Its fields, where they are compared.
    pub(super) fields: Vec<KeptField>,
}

/// An update to do again.
pub(super) struct ReplayStep {
    pub(super) update: Update,
    /// Increments that the state has already.
    pub(super) before: u32,
    /// Increments after those.
    pub(super) done: u32,
    /// Whether it was stopped then.
    pub(super) is_stopped: bool,
    /// What the increments are compared with; empty where nothing is known of them.
    pub(super) known: Vec<Known>,
    /// Whether it is over.
    pub(super) is_finished: bool,
}

impl ReplayStep {
    /// From what is saved or exported; none where that cannot be read.
    pub(super) fn again(work: &StoredWork) -> Option<Self> {
        Some(Self {
            update: read_update(&work.encoded)?,
            before: work.before,
            done: work.done,
            is_stopped: work.stopped,
            known: Vec::new(),
            is_finished: true,
        })
    }

    /// All of a saved path, if no part of it is unreadable or longer than any that is saved.
    pub(super) fn all_again(since: &[StoredWork]) -> Option<Vec<Self>> {
        let increments: u64 = since.iter().map(|work| u64::from(work.done)).sum();
        let is_short = increments <= MOST_RESULTS as u64 && since.len() <= MOST_RESULTS;
        let steps = since.iter().filter(|_| is_short).map(Self::again);
        let steps: Option<Vec<Self>> = steps.collect();
        steps.filter(|_| is_short)
    }
}

/// What an earlier server did in a session.
pub(super) struct Replay {
    pub(super) checkpoint: Option<StoredCheckpoint>,
    /// Up to the state of the checkpoint.
    pub(super) since: Vec<ReplayStep>,
    /// After it.
    pub(super) steps: Vec<ReplayStep>,
    pub(super) ledger: Ledger,
    pub(super) cancel: CancelToken,
}

/// What a replay did.
#[derive(Debug, Default)]
pub(super) struct Replayed {
    pub(super) increments: u32,
    pub(super) seconds: f64,
    /// Events of the results that differ from those of the first run.
    pub(super) differing: Vec<i64>,
    pub(super) ledger: Option<Ledger>,
    /// Another instruction set wrote the checkpoint.
    pub(super) is_foreign: bool,
    /// The newest state that was due for the journal.
    pub(super) checkpoint: Option<StoredCheckpoint>,
    /// How the state came about.
    pub(super) path: Path,
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
        let mut way = Way::new(
            self.checkpoint.map(|one| one.state),
            self.ledger,
            self.cancel,
        );
        way.replayed.is_foreign = is_foreign;
        way.again(&mut session, &self.since)?;
        let mut run = None;
        for step in &self.steps {
            run = way.step(&mut session, step)?;
        }
        let mut replayed = way.replayed;
        replayed.seconds = start.elapsed().as_secs_f64();
        Ok((session, run, replayed))
    }
}

/// Leads a session of the same plan to a saved state; what a replay from there would have to do.
/// After an error the session is anywhere.
pub(super) fn redo(
    session: &mut Session,
    save: &StoredSave,
    ledger: Ledger,
) -> Result<Ledger, ReplayError> {
    let steps = ReplayStep::all_again(&save.since).ok_or(ReplayError::Unreadable)?;
    session.restore(&save.state)?;
    let mut way = Way::new(None, ledger, CancelToken::new());
    way.again(session, &steps)?;
    Ok(way.replayed.ledger.unwrap_or(ledger))
}

struct Way {
    replayed: Replayed,
    cancel: CancelToken,
}

impl Way {
    fn new(state: Option<Bytes>, ledger: Ledger, cancel: CancelToken) -> Self {
        let replayed = Replayed {
            ledger: Some(ledger),
            path: state.map(Path::at).unwrap_or_default(),
            ..Replayed::default()
        };
        Self { replayed, cancel }
    }

    /// Does all of a saved path.
    fn again(&mut self, session: &mut Session, since: &[ReplayStep]) -> Result<(), ReplayError> {
        for step in since {
            self.step(session, step)?;
        }
        self.replayed.path.close();
        Ok(())
    }

    /// Does one update as far as it came; its rest, if there is one.
    fn step(
        &mut self,
        session: &mut Session,
        step: &ReplayStep,
    ) -> Result<Option<StepRun>, ReplayError> {
        let mut run = None;
        // One that was stopped before it began may never have been checked.
        if step.before > 0 || step.done > 0 {
            let mut begun = begin(session, step)?;
            for place in 0..step.done {
                self.increment(session, &mut begun, (step, place))?;
            }
            run = Some(begun);
        }
        if step.is_stopped {
            session.stop();
            self.count(Cost::default(), (step, step.done), Passage::Stopped);
        }
        Ok(run.filter(|_| !step.is_finished))
    }

    fn increment(
        &mut self,
        session: &mut Session,
        run: &mut StepRun,
        (step, place): (&ReplayStep, u32),
    ) -> Result<(), ReplayError> {
        let differs = || ReplayError::Differs(step.update.sequence);
        let done = session.advance(run, &mut Silent, &self.cancel);
        let done = done.ok_or_else(differs)?;
        let (cost, termination) = (Cost::of(&done), done.termination);
        self.replayed.increments += 1;
        let known = step.known.get(place as usize);
        let Some(known) = known else {
            let is_endless = self.replayed.ledger.is_some_and(|one| one.is_endless());
            self.count(cost, (step, place), Passage::Done);
            return if is_endless { Err(differs()) } else { Ok(()) };
        };
        self.compare(session, (step, known), done)?;
        let ledger = self.replayed.ledger;
        if ledger.is_some_and(|one| one.is_due(&cost, termination)) {
            self.checkpoint(session, (step, known), run.done());
        } else {
            self.count(cost, (step, place), Passage::Done);
        }
        Ok(())
    }

    /// Compares an increment with that of the first run.
    fn compare(
        &mut self,
        session: &mut Session,
        (step, known): (&ReplayStep, &Known),
        done: StepReport,
    ) -> Result<(), ReplayError> {
        let sequence = step.update.sequence;
        let number = u32::try_from(sequence).unwrap_or(u32::MAX);
        let again = report::step(numbered(done, number), session.obstacle_poses());
        if again.termination != known.report.termination {
            return Err(ReplayError::Differs(sequence));
        }
        let is_same = bare(again) == bare(known.report.clone()) && has_fields(session, known);
        if !is_same {
            self.replayed.differing.push(known.event);
        }
        Ok(())
    }

    /// Writes the state that was due after an increment.
    fn checkpoint(
        &mut self,
        session: &mut Session,
        (step, known): (&ReplayStep, &Known),
        done: u32,
    ) {
        let newest = step.known.last().map(|one| one.event);
        let is_last = step.is_finished && !step.is_stopped && newest == Some(known.event);
        let state = Bytes::from(session.export());
        self.replayed.path = Path::at(state.clone());
        self.replayed.checkpoint = Some(StoredCheckpoint {
            event: known.event,
            sequence: step.update.sequence,
            done: if is_last { 0 } else { done },
            state,
            since: Vec::new(),
        });
        if let Some(ledger) = &mut self.replayed.ledger {
            ledger.count(Cost::default(), true);
        }
    }

    /// Counts what was done, as the first run did.
    fn count(&mut self, cost: Cost, (step, place): (&ReplayStep, u32), passage: Passage) {
        if let Some(ledger) = &mut self.replayed.ledger {
            ledger.count(cost, false);
        }
        let update = (step.update.sequence, &step.update.encoded);
        let path = &mut self.replayed.path;
        path.count(update, step.before + place, passage);
    }
}

/// Whether the state has the fields of the first run, where these are compared.
fn has_fields(session: &mut Session, known: &Known) -> bool {
    if !known.fields.is_empty() {
        session.complete();
    }
    let mut fields = known.fields.iter();
    fields.all(|first| {
        session
            .field(first.name)
            .map(|one| KeptField::new(&one))
            .as_ref()
            == Some(first)
    })
}

/// The update of a request; none where it cannot be read.
pub(super) fn read_update(encoded: &Bytes) -> Option<Update> {
    let request = wire::SolveRequest::decode(encoded.clone()).ok()?;
    match request.message? {
        solve_request::Message::LoadStep(update) => steps::load_step(&update, encoded.clone()),
        solve_request::Message::ObstacleUpdate(update) => {
            steps::obstacle_update(update, encoded.clone())
        }
        solve_request::Message::Open(_) | solve_request::Message::Cancel(_) => return None,
    }
    .ok()
}

/// Begins an update, or goes on with one from the middle.
fn begin(session: &mut Session, step: &ReplayStep) -> Result<StepRun, ReplayError> {
    let (sequence, load) = (step.update.sequence, &step.update.step);
    match step.before {
        0 => session
            .begin_step(load)
            .map_err(|why| ReplayError::Refused { sequence, why }),
        done => session
            .resume_step(load.increments, done)
            .ok_or(ReplayError::Differs(sequence)),
    }
}

/// Whether an increment was stopped: a replay ends before it.
pub(super) fn is_stopped(report: &wire::StepReport) -> bool {
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
        // Rounded from the number of the step that the solver counts, which leaves out one that
        // was stopped before its first increment.
        time: 0.0,
        ..report
    }
}
