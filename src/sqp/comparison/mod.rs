//! Sessions on the elements that Taylor-Hood is compared with: the same steps,
//! criteria and reports on assembled matrices, for linear mixed scenes, with
//! contact where the trace is P1.
//!
//! ```text
//! f - A u - B^T p - C(u)^T l = 0,   B u - S p = 0,   g(u) >= 0, l >= 0, l g(u) = 0
//! ```
//!
//! One program per increment, more where an obstacle is curved; what rounding
//! leaves is solved once more.

mod body;
mod contact;
mod report;
mod solve;
mod values;

use std::sync::Arc;

use super::constraints::Interfaces;
use super::counters::Counters;
use super::drive::{Drive, ObstaclePose};
use super::increment::Ending;
use super::session::{Reuse, StepRun};
use super::state::{Snapshot, State};
use super::watch::Watch;
use crate::krylov::gcr::Directions;
use crate::linalg::Workspace;
use crate::linalg::vector::dot;
use crate::mesh::Mesh;
use crate::plan::{ComparisonData, Plan};
use crate::report::{
    CancelToken, Cause, FieldData, FieldName, IterationRecord, Observer, Seconds, StepReport,
    Termination,
};
use crate::scene::validate::check_step;
use crate::scene::{SceneError, Step};

use body::Body;

/// Residual below which an iterate that did not converge is kept.
const MEANINGFUL: f64 = 1e-3;

/// A state that load steps move.
#[derive(Debug)]
pub(super) struct Session {
    plan: Arc<Plan>,
    mesh: Arc<Mesh>,
    data: Arc<ComparisonData>,
    interfaces: Interfaces,
    load: Vec<f64>,
    state: State,
    previous: Option<Snapshot>,
    moved: bool,
    target: Drive,
    steps: u32,
    preparation: Seconds,
    reused: Vec<String>,
    pending_factorisations: u32,
    work: Workspace,
}

impl Session {
    pub(super) fn new(
        plan: Arc<Plan>,
        mesh: Arc<Mesh>,
        data: Arc<ComparisonData>,
        reuse: Reuse,
    ) -> Self {
        let start = std::time::Instant::now();
        let interfaces = Interfaces::new(&plan, &mesh, &data.trace);
        let load = Body {
            plan: &plan,
            mesh: &mesh,
            data: &data,
            interfaces: &interfaces,
        }
        .reference_load();
        let own = start.elapsed().as_secs_f64();
        let (mut preparation, reused) = match reuse {
            Reuse::Built => (data.seconds(), Vec::new()),
            Reuse::Reused => (Seconds::default(), data.parts()),
        };
        preparation.assemble += own;
        preparation.total += own;
        Self {
            state: State::undeformed(&plan),
            previous: None,
            moved: false,
            target: Drive::first_target(plan.scene()),
            steps: 0,
            preparation,
            reused,
            pending_factorisations: u32::from(reuse == Reuse::Built),
            work: Workspace::new(),
            plan,
            mesh,
            data,
            interfaces,
            load,
        }
    }

    pub(super) fn plan(&self) -> &Plan {
        &self.plan
    }

    pub(super) fn check_step(&self, step: &Step) -> Result<(), SceneError> {
        check_step(self.plan.scene(), step, &self.mesh)
    }

    pub(super) fn begin_step(&mut self, step: &Step) -> Result<StepRun, SceneError> {
        self.check_step(step)?;
        let end = self.target.after(self.plan.scene(), step);
        self.steps += 1;
        self.target = end.clone();
        Ok(StepRun::new(self.state.drive.clone(), end, step.increments))
    }

    pub(super) fn advance(
        &mut self,
        run: &mut StepRun,
        observer: &mut dyn Observer,
        cancel: &CancelToken,
    ) -> Option<StepReport> {
        let (increment, goal) = run.upcoming()?;
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
        let body = self.body();
        let mut ending = body.solve(
            &self.load,
            &mut state,
            &goal,
            &mut watch,
            &mut counters,
            &mut work,
        );
        self.centre_pressure(&mut state);
        let reached = self.settle(&mut state, &before, &mut ending, &mut work);
        let fraction = match reached {
            true => f64::from(increment),
            false => f64::from(increment - 1),
        } / f64::from(run.increments());
        self.state = state;
        if ending.is_stopped() {
            self.previous = None;
            self.stop();
        }
        run.finish(increment, ending.termination);
        let report = self.report(increment, fraction, &ending, &counters, &mut work);
        self.work = work;
        Some(report)
    }

    /// Keeps the new state if it is of use, else returns to the one before.
    fn settle(
        &mut self,
        state: &mut State,
        before: &Snapshot,
        ending: &mut Ending,
        work: &mut Workspace,
    ) -> bool {
        let is_enclosed = self.data.pressure.is_enclosed;
        let touches = state.active.iter().any(|&active| active);
        let stuck = matches!(
            ending.cause,
            Some(Cause::Stagnation | Cause::IterationLimit)
        );
        if stuck && self.plan.is_floating() && !touches {
            ending.cause = Some(Cause::NoEquilibrium);
        } else if stuck && is_enclosed {
            ending.cause = Some(Cause::EnclosedVolume);
        }
        let is_unbounded = matches!(
            ending.cause,
            Some(Cause::NoEquilibrium | Cause::EnclosedVolume | Cause::NotFinite)
        );
        let is_bounded = ending.residuals.largest() < MEANINGFUL && !is_unbounded;
        let is_good = match ending.termination {
            Termination::Converged => true,
            Termination::NotConverged => is_bounded,
            Termination::Cancelled | Termination::DeadlineExceeded | Termination::InternalError => {
                false
            }
        };
        if !is_good {
            state.restore(before);
            self.body().describe(&self.load, state, ending, work);
        }
        self.moved |= !ending.is_stopped();
        is_good
    }

    pub(super) fn stop(&mut self) {
        self.target = match self.moved {
            true => self.state.drive.clone(),
            false => Drive::first_target(self.plan.scene()),
        };
        self.state.directions = Directions::default();
    }

    pub(super) fn take_back(&mut self) {
        if let Some(previous) = self.previous.take() {
            self.state.restore(&previous);
            self.moved = self.state.drive != Drive::undeformed(self.plan.scene());
        }
        self.stop();
    }

    /// An enclosed incompressible body fixes its pressure up to a constant: the
    /// mean is set to zero.
    fn centre_pressure(&self, state: &mut State) {
        let pressure = &self.data.pressure;
        if pressure.is_enclosed {
            let volume = pressure.weights.iter().sum::<f64>();
            let mean = dot(&pressure.weights, &state.pressure) / volume;
            state.pressure.iter_mut().for_each(|p| *p -= mean);
        }
    }

    fn body(&self) -> Body<'_> {
        Body {
            plan: &self.plan,
            mesh: &self.mesh,
            data: &self.data,
            interfaces: &self.interfaces,
        }
    }

    fn report(
        &mut self,
        increment: u32,
        fraction: f64,
        ending: &Ending,
        counters: &Counters,
        work: &mut Workspace,
    ) -> StepReport {
        let body = self.body();
        let mut report = body.report(&self.load, &self.state, ending, counters, work);
        report.step = self.steps;
        report.increment = increment;
        report.time = f64::from(self.steps - 1) + fraction;
        report.memory_bytes = self.data.bytes() + self.state.bytes() + work.bytes();
        let preparation = std::mem::take(&mut self.preparation);
        report.reused = std::mem::take(&mut self.reused);
        report.factorisations = std::mem::take(&mut self.pending_factorisations);
        report.seconds.prepare += preparation.prepare;
        report.seconds.assemble += preparation.assemble;
        report.seconds.factorise += preparation.factorise;
        report.seconds.total = preparation.total + counters.start.elapsed().as_secs_f64();
        report
    }

    pub(super) fn field(&self, name: FieldName) -> Option<FieldData> {
        self.body().field(&self.state, name)
    }

    pub(super) fn bytes(&self) -> u64 {
        let previous = self.previous.as_ref().map_or(0, Snapshot::bytes);
        self.state.bytes() + previous + self.work.bytes() + 8 * self.load.len() as u64
    }

    pub(super) fn obstacle_poses(&self) -> Vec<ObstaclePose> {
        self.state.drive.poses.clone()
    }
}
