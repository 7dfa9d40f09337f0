//! A session: one state on shared prepared data, moved by load steps.
//!
//! A session owns two things that change: the state, which is all that a resumed session
//! needs, and what the solver has learnt, which may be dropped between any two increments.
//! Everything else is shared and immutable. A step that is begun ramps from where the last
//! one led to, reached or not.

pub(crate) mod body;
pub(crate) mod checkpoint;
mod goals;
mod refined;
mod snapshot;
mod step_run;
mod taylor_hood;

use std::sync::Arc;

use crate::linalg::Workspace;
use crate::mesh::Mesh;
use crate::model::counters::Counters;
use crate::model::drive::Drive;
use crate::model::ending::Ending;
use crate::model::state::State;
use crate::plan::Plan;
use crate::prepare::Prepared;
use crate::report::{
    CancelToken, FieldData, FieldName, IterationRecord, Observer, Seconds, Silent, StepReport,
    Termination, WarningKind,
};
use crate::scene::validate::check_step;
use crate::scene::{InStep, SceneError, Step};
use crate::sqp::learned::Learned;
use crate::sqp::watch::Watch;
use body::{Advanced, Increment};
use taylor_hood::TaylorHoodBody;

use checkpoint::Checkpoint;

pub use crate::model::drive::ObstaclePose;
pub use checkpoint::{CheckpointError, Origin, Rounding};
pub use refined::NotCarried;
pub use snapshot::Snapshot;
pub use step_run::{Reuse, StepRun};

/// A state that load steps move.
#[derive(Debug)]
pub struct Session {
    /// The body on its obstacles.
    body: TaylorHoodBody,
    /// The checkpoint: all that a resumed session needs.
    state: State,
    /// What earlier programs have taught the solver; droppable.
    learned: Learned,
    /// The state before the increment that [`Session::take_back`] can undo.
    previous: Option<State>,
    /// Whether any increment has moved the state from rest.
    moved: bool,
    /// What the last step led to, reached or not: the next step starts its ramps there.
    target: Drive,
    /// Where the last step began, as its drive; none where none did, or the last one was
    /// stopped.
    begun: Option<Drive>,
    /// Number of steps begun so far.
    steps: u32,
    /// Seconds of the preparation that the next report still has to name.
    preparation: Seconds,
    /// Prepared parts taken from a cache that the next report still has to name.
    reused: Vec<String>,
    /// Factorisations that the next report still has to count.
    pending_factorisations: u32,
    /// Scratch vectors, kept from increment to increment.
    work: Workspace,
    /// Part of each cell in the error of the first goal whose error is bounded; none where the
    /// last increment has none.
    parts: Option<Vec<f64>>,
    /// Derivative of the first goal with a gradient by the mesh `[used vertices][3]`; none where the last
    /// increment left none.
    by_nodes: Option<Vec<[f64; 3]>>,
    /// Keeps the shared data in use, so that a cache counts them as such.
    _prepared: Arc<Prepared>,
}

impl Session {
    /// A session in the undeformed state.
    pub fn new(plan: Arc<Plan>, mesh: Arc<Mesh>, prepared: Arc<Prepared>, reuse: Reuse) -> Self {
        let start = std::time::Instant::now();
        let mesh = plan.body_mesh(&mesh);
        let body = TaylorHoodBody::new(plan.clone(), mesh, prepared.data());
        let own = start.elapsed().as_secs_f64();
        let shared = body.shared();
        let (mut preparation, reused) = match reuse {
            Reuse::Built => (shared.seconds, Vec::new()),
            Reuse::Reused => (Seconds::default(), shared.parts),
        };
        preparation.assemble += own;
        preparation.total += own;
        Self {
            state: State::undeformed(&plan),
            learned: Learned::nothing(&plan),
            previous: None,
            moved: false,
            target: Drive::first_target(&plan),
            begun: None,
            pending_factorisations: u32::from(reuse == Reuse::Built),
            steps: 0,
            preparation,
            reused,
            work: Workspace::new(),
            parts: None,
            by_nodes: None,
            body,
            _prepared: prepared,
        }
    }

    /// A session that goes on where [`Session::export`] wrote `bytes`, in this process
    /// or another: with the same bits from the same build. `prepared` is of `plan`, as
    /// in [`Session::new`]. Cost: one pass over the bytes besides.
    ///
    /// # Errors
    /// [`CheckpointError`] for bytes that were not written by this format, were changed
    /// since, or belong to another mesh, scene, plan or instruction set.
    pub fn import(
        plan: Arc<Plan>,
        mesh: Arc<Mesh>,
        prepared: Arc<Prepared>,
        reuse: Reuse,
        bytes: &[u8],
    ) -> Result<Self, CheckpointError> {
        let checkpoint = Checkpoint::decode(&plan, bytes, Rounding::Same)?;
        Ok(Self::of_checkpoint(plan, mesh, prepared, reuse, checkpoint))
    }

    /// As [`Session::import`], for bytes that another instruction set may have rounded:
    /// later results are then the same up to rounding.
    ///
    /// # Errors
    /// As [`Session::import`].
    pub fn import_rounded(
        plan: Arc<Plan>,
        mesh: Arc<Mesh>,
        prepared: Arc<Prepared>,
        reuse: Reuse,
        bytes: &[u8],
    ) -> Result<Self, CheckpointError> {
        let checkpoint = Checkpoint::decode(&plan, bytes, Rounding::Any)?;
        Ok(Self::of_checkpoint(plan, mesh, prepared, reuse, checkpoint))
    }

    fn of_checkpoint(
        plan: Arc<Plan>,
        mesh: Arc<Mesh>,
        prepared: Arc<Prepared>,
        reuse: Reuse,
        checkpoint: Checkpoint,
    ) -> Self {
        let mut session = Self::new(plan, mesh, prepared, reuse);
        session.take_up(checkpoint);
        session
    }

    /// Goes back to where [`Session::export`] wrote `bytes`, of this session or of another one
    /// of the same plan, and on from there with the same bits as from there before. A step
    /// under way is forgotten: [`Session::resume_step`] where the bytes are from the middle of
    /// one. Cost: one pass over the bytes.
    ///
    /// # Errors
    /// As [`Session::import`]; the session is then as before.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), CheckpointError> {
        let checkpoint = Checkpoint::decode(self.plan(), bytes, Rounding::Same)?;
        self.take_up(checkpoint);
        self.learned.forget(self.body.plan());
        self.previous = None;
        Ok(())
    }

    fn take_up(&mut self, checkpoint: Checkpoint) {
        let Checkpoint {
            state,
            target,
            begun,
            steps,
            moved,
        } = checkpoint;
        self.state = state;
        self.target = target;
        self.begun = begun;
        self.steps = steps;
        self.moved = moved;
    }

    /// Whether [`Session::import`] takes `bytes` on a session of `plan`, before anything
    /// is prepared.
    ///
    /// # Errors
    /// Those of the import.
    pub fn check_import(
        plan: &Plan,
        bytes: &[u8],
        rounding: Rounding,
    ) -> Result<(), CheckpointError> {
        Checkpoint::decode(plan, bytes, rounding).map(|_| ())
    }

    /// The state between two increments as bytes, for [`Session::import`]; they begin
    /// with their version and end with their digest. This session forgets what the
    /// solver has learnt, which does not travel and which later bits depend on: both
    /// sessions go on with the same bits. [`Session::take_back`] has nothing to undo
    /// in either, and stops the step. A step under way goes on here with the
    /// [`StepRun`] that is there, and in the other session with
    /// [`Session::resume_step`]. After a panic inside [`Session::advance`],
    /// [`Session::take_back`] first. Cost: two copies of the state.
    pub fn export(&mut self) -> Vec<u8> {
        self.forget();
        self.previous = None;
        self.to_bytes()
    }

    /// The state between two increments as [`Session::export`] writes it; this session stays as it
    /// is. With what the solver has learnt, which is not in them, it goes on with other bits than
    /// a session of these bytes, unless it has just forgotten that ([`Session::forget`]).
    pub fn to_bytes(&self) -> Vec<u8> {
        self.checkpoint().encode(self.plan())
    }

    /// The bytes of a session of `plan` before its first step.
    pub fn at_rest(plan: &Plan) -> Vec<u8> {
        let checkpoint = Checkpoint {
            state: State::undeformed(plan),
            target: Drive::first_target(plan),
            begun: None,
            steps: 0,
            moved: false,
        };
        checkpoint.encode(plan)
    }

    fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            state: self.state.clone(),
            target: self.target.clone(),
            begun: self.begun.clone(),
            steps: self.steps,
            moved: self.moved,
        }
    }

    /// Forgets what the solver has learnt, as [`Session::export`] does, and writes nothing: the
    /// session goes on with the bits of one that exports here.
    pub fn forget(&mut self) {
        self.complete();
        self.state.surface_load = None;
        self.learned.forget(self.body.plan());
    }

    /// The step begun last, of which `done` of its `increments` are done, for a session
    /// that was imported in the middle of it; none where no step was begun, or the last
    /// one was stopped. The limit of time counts from here.
    pub fn resume_step(&self, increments: u32, done: u32) -> Option<StepRun> {
        let step = StepRun::new(self.begun.clone()?, self.target.clone(), increments);
        Some(step.after(done))
    }

    /// The plan this session follows.
    pub fn plan(&self) -> &Plan {
        self.body.plan()
    }

    /// Checks a step without taking it.
    ///
    /// # Errors
    /// [`SceneError`] with the path of every faulty key.
    pub fn check_step(&self, step: &Step) -> Result<(), SceneError> {
        check_step(self.plan().scene(), step, self.body.mesh())?;
        self.plan().check_turned_planes(step)?;
        self.plan().check_friction(step)
    }

    /// Starts a step; [`Session::advance`] then does its increments.
    ///
    /// # Errors
    /// [`SceneError`]; the session is then as before.
    pub fn begin_step(&mut self, step: &Step) -> Result<StepRun, SceneError> {
        self.check_step(step)?;
        // Where a push has led an obstacle is known now.
        let reached = self.target.carried_by(&self.state.drive);
        let end = reached.after(self.plan(), step);
        let end = end.given_by((self.plan(), self.body.mesh()), step);
        self.steps += 1;
        self.target = end.clone();
        let start = self.start_towards(&end);
        let start = self.begun.insert(start);
        Ok(StepRun::new(start.clone(), end, step.increments))
    }

    /// What drives the body now, with what its parts exert where `end` pushes them.
    fn start_towards(&self, end: &Drive) -> Drive {
        let mut now = self.state.drive.about_like(end);
        let pairs = now.motions.iter().zip(&self.state.drive.motions);
        let mut pairs = pairs.map(|(now, before)| [now.about, before.about]);
        let is_about_others =
            pairs.any(|[now, before]| now.map(f64::to_bits) != before.map(f64::to_bits));
        if now.controls() == end.controls() && !is_about_others {
            return now;
        }
        if is_about_others {
            // Moments about other points are others.
            now.support_pushes.clear();
        }
        let state = State {
            drive: now.clone(),
            ..self.state.clone()
        };
        now.pushing_like(end, &self.body.applied(&state, end))
    }

    /// Does the next increment; none when the step is finished. A result that
    /// did not converge finishes the step, with the last good state kept. One that
    /// was cancelled leaves the state before the increment, so that no later bit
    /// depends on when that was; one whose time is up the last part of the increment
    /// that converged, which the report names: nothing else depends on the clock.
    /// After a panic inside, [`Session::take_back`].
    pub fn advance(
        &mut self,
        step: &mut StepRun,
        observer: &mut dyn Observer,
        cancel: &CancelToken,
    ) -> Option<StepReport> {
        let (number, goal) = step.upcoming()?;
        let before = self.previous.insert(self.state.clone());
        let increment = Increment {
            state: &mut self.state,
            learned: &mut self.learned,
            watch: Watch {
                observer,
                cancel,
                seconds_left: step.seconds_left(self.body.plan().problem.settings.max_wall_time),
                record: IterationRecord {
                    step: self.steps,
                    increment: number,
                    load: goal.load,
                    ..IterationRecord::default()
                },
            },
            counters: Counters::new(),
            work: std::mem::take(&mut self.work),
        };
        let advanced = self.body.advance(increment, &goal, before);
        let is_stopped = advanced.ending.is_stopped();
        if is_stopped && advanced.part == 0.0 {
            self.previous = None
        } else {
            self.moved = true
        }
        if is_stopped {
            self.stop();
        }
        if advanced.ending.leak.is_some() {
            self.end_at_blow_off(&advanced.ending);
        }
        step.finish(number, &advanced.ending, &advanced.counters);
        let time = step.time(number, advanced.part);
        let mut report = self.report(time, advanced);
        let place = if step.upcoming().is_some() {
            InStep::Before
        } else {
            InStep::Last
        };
        self.add_goals(&mut report, (place, cancel));
        self.state.remainder = None;
        if place == InStep::Before {
            // What is on its way may touch at the end.
            let warnings = &mut report.warnings;
            warnings.retain(|warning| warning.kind != WarningKind::UntouchedObstacle);
        }
        Some(report)
    }

    /// Lets the next step start from where a fluid was about to leak, where that was sought.
    fn end_at_blow_off(&mut self, ending: &Ending) {
        if ending.termination == Termination::Converged {
            self.target = self.state.drive.clone();
            self.begun = None;
        }
    }

    /// Ends a step before its end: what follows starts from the state that is
    /// there, as if the step had only asked for that. Forgets what the solver has
    /// learnt, which depends on how far it came: no later bit depends on when a
    /// step was stopped.
    pub fn stop(&mut self) {
        let plan = self.body.plan();
        self.target = if self.moved {
            self.state.drive.clone()
        } else {
            Drive::first_target(plan)
        };
        self.begun = None;
        self.learned.forget(plan);
    }

    /// Undoes the last increment, if it is not undone yet, and stops its step.
    /// Also mends a session in which [`Session::advance`] panicked.
    pub fn take_back(&mut self) {
        if let Some(previous) = self.previous.take() {
            self.state = previous;
            self.moved = self.state.drive != Drive::undeformed(self.plan());
        }
        self.stop();
    }

    /// The report of an increment that came to `reached` of its step.
    fn report(&mut self, (increment, reached): (u32, f64), mut advanced: Advanced) -> StepReport {
        let mut report = self.body.report(&self.state, &mut advanced);
        self.work = advanced.work;
        report.step = self.steps;
        report.increment = increment;
        report.time = f64::from(self.steps - 1) + reached;
        let own = self.state.bytes() + self.learned.bytes() + self.work.bytes();
        report.memory_bytes = self.body.shared().bytes + own;
        let preparation = std::mem::take(&mut self.preparation);
        report.reused = std::mem::take(&mut self.reused);
        let built = std::mem::take(&mut self.pending_factorisations);
        report.factorisations += built;
        if built > 0 {
            self.body.count_preparation(&mut report);
        }
        report.seconds.prepare += preparation.prepare;
        report.seconds.assemble += preparation.assemble;
        report.seconds.factorise += preparation.factorise;
        let seconds = advanced.counters.start.elapsed().as_secs_f64();
        report.seconds.total = preparation.total + seconds;
        report
    }

    /// Finds what the body does inside where the last report was on contact alone. Fields do it
    /// by themselves, each anew: worth the call before several. Changes no later bit. Cost: one
    /// solution with the factor, none after a report on the whole body.
    pub fn complete(&mut self) {
        let increment = Increment {
            state: &mut self.state,
            learned: &mut self.learned,
            watch: Watch {
                observer: &mut Silent,
                cancel: &CancelToken::new(),
                seconds_left: None,
                record: IterationRecord::default(),
            },
            counters: Counters::new(),
            work: std::mem::take(&mut self.work),
        };
        self.work = self.body.complete(increment);
    }

    /// A field of the current state; none if the scene has no such field.
    pub fn field(&self, name: FieldName) -> Option<FieldData> {
        if name == FieldName::ErrorDensity {
            return self.error_density();
        }
        if name == FieldName::MeshGradient {
            return self.mesh_gradient();
        }
        self.body.field((&self.state, &self.learned), name)
    }

    /// Bytes held by this session alone.
    pub fn bytes(&self) -> u64 {
        let previous = self.previous.as_ref().map_or(0, State::bytes);
        let moving = self.state.bytes() + self.learned.bytes() + previous;
        moving + self.work.bytes() + self.body.bytes()
    }

    /// Number of steps begun so far, those before a checkpoint included.
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// Whether the response of the body at the contact surface, if it shall be kept, is among
    /// [`Session::bytes`] already, or was found not to fit.
    pub fn has_tried_response(&self) -> bool {
        self.learned.has_tried_response()
    }

    /// Current poses of all obstacles.
    pub fn obstacle_poses(&self) -> Vec<ObstaclePose> {
        self.state.drive.poses.clone()
    }
}
