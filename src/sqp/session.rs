//! A session: one state on shared prepared data, moved by load steps.

mod approach;
mod parts;
mod relief;

use std::sync::Arc;

use super::constraints::Interfaces;
use super::counters::Counters;
use super::drive::{Drive, ObstaclePose};
use super::evaluate::Context;
use super::increment::{self, Ending};
use super::loads::reference_load;
use super::state::{Snapshot, State};
use super::watch::Watch;
use super::{fields, results, verification};
use crate::linalg::Workspace;
use crate::mesh::Mesh;
use crate::plan::{Plan, TaylorHoodData as Prepared};
use crate::report::{
    CancelToken, FieldData, FieldName, IterationRecord, Observer, Seconds, StepReport, Termination,
};
use crate::scene::validate::check_step;
use crate::scene::{SceneError, Step};

/// Where the prepared data came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reuse {
    /// Built for this session: its seconds count in the first step.
    Built,
    /// Taken from a cache.
    Reused,
}

/// A state that load steps move.
#[derive(Debug)]
pub(super) struct Session {
    plan: Arc<Plan>,
    mesh: Arc<Mesh>,
    prepared: Arc<Prepared>,
    interfaces: Interfaces,
    load: Vec<f64>,
    state: State,
    /// The state before the increment that [`Session::take_back`] can undo.
    previous: Option<Snapshot>,
    /// Whether any increment has moved the state.
    moved: bool,
    /// What the last step led to, reached or not.
    target: Drive,
    steps: u32,
    /// Seconds and parts that the next report still has to name.
    preparation: Seconds,
    reused: Vec<String>,
    pending_factorisations: u32,
    work: Workspace,
}

/// A step under way.
#[derive(Clone, Debug)]
pub struct StepRun {
    start: Drive,
    end: Drive,
    increments: u32,
    done: u32,
    finished: bool,
}

impl StepRun {
    pub(super) fn new(start: Drive, end: Drive, increments: u32) -> Self {
        Self {
            start,
            end,
            increments,
            done: 0,
            finished: false,
        }
    }

    /// Number and drive of the next increment; none when the step is finished.
    pub(super) fn upcoming(&self) -> Option<(u32, Drive)> {
        let increment = self.done + 1;
        if self.finished || increment > self.increments {
            return None;
        }
        let fraction = f64::from(increment) / f64::from(self.increments);
        Some((increment, self.start.towards(&self.end, fraction)))
    }

    /// Notes how an increment ended.
    pub(super) fn finish(&mut self, increment: u32, termination: Termination) {
        self.done = increment;
        self.finished = termination != Termination::Converged;
    }

    /// Increments finished so far.
    pub fn done(&self) -> u32 {
        self.done
    }

    /// Increments in all.
    pub fn increments(&self) -> u32 {
        self.increments
    }
}

impl Session {
    /// A session in the undeformed state.
    pub(super) fn new(
        plan: Arc<Plan>,
        mesh: Arc<Mesh>,
        prepared: Arc<Prepared>,
        reuse: Reuse,
    ) -> Self {
        let start = std::time::Instant::now();
        let interfaces = Interfaces::new(&plan, &mesh, &prepared.space);
        let load = reference_load(&plan, &mesh, &prepared);
        let own = start.elapsed().as_secs_f64();
        let (mut preparation, reused) = match reuse {
            Reuse::Built => (prepared.seconds(), Vec::new()),
            Reuse::Reused => (Seconds::default(), prepared.parts()),
        };
        preparation.assemble += own;
        preparation.total += own;
        let mut state = State::undeformed(&plan);
        if plan.first_penalty() > 0.0 {
            state.penalise(&prepared, plan.first_penalty());
        }
        Self {
            state,
            previous: None,
            moved: false,
            target: Drive::first_target(plan.scene()),
            pending_factorisations: u32::from(reuse == Reuse::Built),
            plan,
            mesh,
            prepared,
            interfaces,
            load,
            steps: 0,
            preparation,
            reused,
            work: Workspace::new(),
        }
    }

    /// The plan this session follows.
    pub(super) fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Checks a step without taking it.
    ///
    /// # Errors
    /// [`SceneError`] with the path of every faulty key.
    pub(super) fn check_step(&self, step: &Step) -> Result<(), SceneError> {
        check_step(self.plan.scene(), step, &self.mesh)
    }

    /// Starts a step; [`Session::advance`] then does its increments.
    ///
    /// # Errors
    /// [`SceneError`]; the session is then as before.
    pub(super) fn begin_step(&mut self, step: &Step) -> Result<StepRun, SceneError> {
        self.check_step(step)?;
        let end = self.target.after(self.plan.scene(), step);
        self.steps += 1;
        self.target = end.clone();
        Ok(StepRun::new(self.state.drive.clone(), end, step.increments))
    }

    /// Does the next increment; none when the step is finished. A result that
    /// did not converge finishes the step, with the last good state kept. One that
    /// was cancelled leaves the state before the increment, so that no later bit
    /// depends on when that was; one whose time is up the last part of the increment
    /// that converged, which the report names: nothing else depends on the clock.
    /// After a panic inside, [`Session::take_back`].
    pub(super) fn advance(
        &mut self,
        run: &mut StepRun,
        observer: &mut dyn Observer,
        cancel: &CancelToken,
    ) -> Option<StepReport> {
        let (increment, goal) = run.upcoming()?;
        let fraction = f64::from(increment) / f64::from(run.increments);
        let mut counters = Counters::new();
        let mut work = std::mem::take(&mut self.work);
        let mut watch = Watch {
            observer,
            cancel,
            max_wall_time: self.plan.scene.solver.max_wall_time,
            record: IterationRecord {
                step: self.steps,
                increment,
                load: goal.load,
                ..IterationRecord::default()
            },
        };
        let before = self.state.snapshot();
        self.previous = Some(before.clone());
        let mut state = std::mem::replace(&mut self.state, State::undeformed(&self.plan));
        let (mut ending, part) =
            self.approach(&mut state, &goal, &mut watch, &mut counters, &mut work);
        let is_left = ending.is_stopped() && part == 0.0;
        if is_left {
            state.restore(&before);
            self.previous = None;
        } else {
            self.moved = true;
        }
        if ending.is_stopped() {
            increment::describe(&self.context(), &mut state, &mut ending, &mut work);
        }
        self.state = state;
        if ending.is_stopped() {
            self.stop();
        }
        run.finish(increment, ending.termination);
        let before = f64::from(increment - 1) / f64::from(run.increments);
        let reached = before + part * (fraction - before);
        let report = self.report(increment, reached, &ending, &counters, &mut work);
        self.work = work;
        Some(report)
    }

    /// Ends a step before its end: what follows starts from the state that is
    /// there, as if the step had only asked for that. Forgets what the solver has
    /// learnt, which depends on how far it came: no later bit depends on when a
    /// step was stopped.
    pub(super) fn stop(&mut self) {
        self.target = match self.moved {
            true => self.state.drive.clone(),
            false => Drive::first_target(self.plan.scene()),
        };
        self.state.forget(&self.plan);
    }

    /// Undoes the last increment, if it is not undone yet, and stops its step.
    /// Also mends a session in which [`Session::advance`] panicked.
    pub(super) fn take_back(&mut self) {
        if let Some(previous) = self.previous.take() {
            self.state.restore(&previous);
            self.moved = self.state.drive != Drive::undeformed(self.plan.scene());
        }
        self.stop();
    }

    fn context(&self) -> Context<'_> {
        Context {
            plan: &self.plan,
            mesh: &self.mesh,
            prepared: &self.prepared,
            interfaces: &self.interfaces,
            load: &self.load,
            relief: &[],
            tolerance: self.plan.scene.solver.tolerance,
        }
    }

    fn report(
        &mut self,
        increment: u32,
        reached: f64,
        ending: &Ending,
        counters: &Counters,
        work: &mut Workspace,
    ) -> StepReport {
        let context = self.context();
        let mut report = results::report(&context, &self.state, ending, counters, work);
        report.step = self.steps;
        report.increment = increment;
        report.time = f64::from(self.steps - 1) + reached;
        report.memory_bytes = self.prepared.bytes() + self.state.bytes() + work.bytes();
        if self.plan.scene.solver.verify {
            report.verification = Some(verification::verify(&context, &self.state, ending));
        }
        let preparation = std::mem::take(&mut self.preparation);
        report.reused = std::mem::take(&mut self.reused);
        let built = std::mem::take(&mut self.pending_factorisations);
        report.factorisations += built;
        if built > 0 {
            report.eigenvalue_applications += crate::precond::PMultigrid::estimate_applications();
            report.compliance_columns = self.prepared.at_rest.compliance.columns() as u32;
        }
        report.seconds.prepare += preparation.prepare;
        report.seconds.assemble += preparation.assemble;
        report.seconds.factorise += preparation.factorise;
        report.seconds.total = preparation.total + counters.start.elapsed().as_secs_f64();
        report
    }

    /// A field of the current state; none if the scene has no such field.
    pub(super) fn field(&self, name: FieldName) -> Option<FieldData> {
        fields::field(&self.context(), &self.state, name)
    }

    /// Bytes held by this session alone.
    pub(super) fn bytes(&self) -> u64 {
        self.state.bytes() + self.previous_bytes() + self.work.bytes() + 8 * self.load.len() as u64
    }

    fn previous_bytes(&self) -> u64 {
        self.previous.as_ref().map_or(0, Snapshot::bytes)
    }

    /// Current poses of all obstacles.
    pub(super) fn obstacle_poses(&self) -> Vec<ObstaclePose> {
        self.state.drive.poses.clone()
    }
}
