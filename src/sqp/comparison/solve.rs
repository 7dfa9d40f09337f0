//! One increment: residuals, the program, residuals again.

use super::super::contact_metric::expected_contact_norm;
use super::super::counters::Counters;
use super::super::drive::Drive;
use super::super::evaluate::{Evaluation, mask, norm_of};
use super::super::increment::{Ending, ending, residuals, stop_reason};
use super::super::linear::Track;
use super::super::state::State;
use super::super::watch::Watch;
use super::body::Body;
use crate::inequality::{
    InequalitySolver, OneLevel, QpIterate, QpNorms, QpOutcome, QpProblem, QpRun, QpScales,
    QpTargets,
};
use crate::linalg::vector::{add_scaled, norm};
use crate::linalg::{LinearOperator, Workspace};
use crate::precond::Counted;
use crate::report::{Cause, Termination};
use crate::saddle::{BlockStep, MultiplierBlock};

/// Krylov iterations per program.
const MOST_ITERATIONS: u32 = 1000;
/// Programs per increment.
const MOST_PROGRAMS: u32 = 40;
/// Reduction asked of a program with a curved gap.
const REDUCTION: f64 = 1e-2;
/// Aim of a program below the tolerance, for what the recomputed residual adds.
const MARGIN: f64 = 0.95;

impl Body<'_> {
    /// A u + B^T p, all rows.
    pub(super) fn internal_force(&self, state: &State, work: &mut Workspace) -> Vec<f64> {
        let mut force = vec![0.0; state.displacement.len()];
        let mut part = work.scratch(force.len());
        let matrix = &self.data.stiffness.matrix;
        matrix.apply(&state.displacement, &mut force, work);
        let transposed = &self.data.pressure.coupling.transposed;
        transposed.apply(&state.pressure, &mut part, work);
        add_scaled(&mut force, 1.0, &part);
        work.give(part);
        force
    }

    fn evaluate(
        &self,
        load: &[f64],
        state: &State,
        drive: &Drive,
        work: &mut Workspace,
    ) -> Evaluation {
        let held = &self.data.held;
        let mut force: Vec<f64> = load.iter().map(|value| value * drive.load).collect();
        mask(held, &mut force);
        let mut out = Evaluation {
            load_norm: norm(&force),
            ..Evaluation::default()
        };
        add_scaled(&mut force, -1.0, &self.internal_force(state, work));
        self.add_contact(state, drive, &mut force, &mut out, work);
        if drive.moves_supports() {
            out.reaction_norm = norm_of(held, &force);
        }
        mask(held, &mut force);
        out.force = force;
        out.constraint = self.constraint(state, work);
        out
    }

    /// -(B u - S p).
    fn constraint(&self, state: &State, work: &mut Workspace) -> Vec<f64> {
        let block = &self.data.pressure;
        let mut residual = vec![0.0; state.pressure.len()];
        let matrix = &block.coupling.matrix;
        matrix.apply(&state.displacement, &mut residual, work);
        residual.iter_mut().for_each(|value| *value = -*value);
        if let Some(stabilisation) = &block.stabilisation {
            let mut product = work.scratch(residual.len());
            stabilisation.apply(&state.pressure, &mut product, work);
            add_scaled(&mut residual, 1.0, &product);
            work.give(product);
        }
        residual
    }

    /// Moves `state` to equilibrium under `drive`.
    pub(super) fn solve(
        &self,
        load: &[f64],
        state: &mut State,
        drive: &Drive,
        watch: &mut Watch<'_>,
        counters: &mut Counters,
        work: &mut Workspace,
    ) -> Ending {
        self.prescribe(drive, &mut state.displacement);
        state.drive = drive.clone();
        let tolerance = self.plan.scene.solver.tolerance;
        let mut now = self.evaluate(load, state, drive, work);
        let first = norm(&now.force);
        let mut failed = None;
        for _ in 0..MOST_PROGRAMS {
            let worst = residuals(state, &now, first).largest();
            let verdict = match watch.stopped(counters) {
                _ if !worst.is_finite() => {
                    Some((Termination::NotConverged, Some(Cause::NotFinite)))
                }
                _ if worst <= tolerance => Some((Termination::Converged, None)),
                Some(termination) => Some((termination, None)),
                None => failed,
            };
            if let Some((termination, cause)) = verdict {
                return ending(tolerance, state, &now, first, termination, cause);
            }
            counters.sqp_iterations += 1;
            let goal = match self.interfaces.are_flat() {
                true => 0.0,
                false => REDUCTION * worst,
            };
            let outcome = self.run_program(state, &now, first, goal, watch, counters, work);
            counters.set_changes += outcome.set_changes;
            failed = stop_reason(outcome.status, watch);
            now = self.evaluate(load, state, drive, work);
        }
        let cause = Some(Cause::IterationLimit);
        ending(
            tolerance,
            state,
            &now,
            first,
            Termination::NotConverged,
            cause,
        )
    }

    #[allow(clippy::too_many_arguments)]
    fn run_program(
        &self,
        state: &mut State,
        now: &Evaluation,
        first: f64,
        goal: f64,
        watch: &mut Watch<'_>,
        counters: &mut Counters,
        work: &mut Workspace,
    ) -> QpOutcome {
        let compliance = self.compliance(&now.coupling);
        let expected = expected_contact_norm(&compliance, now, state, work);
        let block = &self.data.pressure;
        let stabilisation = block.stabilisation.as_ref();
        let blocks = [MultiplierBlock {
            coupling: &block.coupling,
            stabilisation: stabilisation.map(|s| s as &dyn LinearOperator),
            joint: None,
            metric: &*block.metric,
        }];
        let displacement = Counted::new(&self.data.displacement);
        let problem = OneLevel::new(QpProblem {
            stiffness: &self.data.stiffness,
            curvature: None,
            displacement: &displacement,
            step: BlockStep::UpperTriangular,
            equality: &blocks,
            coupling: &now.coupling,
            metric: &compliance,
            weights: &[],
        });
        let targets = QpTargets {
            force_scale: now.force_scale(first).max(expected),
            level: goal.max(MARGIN * self.plan.scene.solver.tolerance),
        };
        let mut iterate = QpIterate {
            displacement: vec![0.0; state.displacement.len()],
            equality: vec![0.0; state.pressure.len()],
            multiplier: state.multiplier.clone(),
            force: now.force.clone(),
            constraint: now.constraint.clone(),
            gap: now.gap.clone(),
            active: state.active.clone(),
        };
        let mut scales = state.scales;
        let krylov = std::time::Instant::now();
        let mut track = Track {
            before: counters.applications,
            force_scale: targets.force_scale,
            displacement: &displacement,
            watch,
            counters,
        };
        let mut progress = |norms: &QpNorms, scales: &QpScales, active: usize| {
            track.iteration(norms, scales, active)
        };
        let mut run = QpRun {
            targets,
            scales: &mut scales,
            iterations: MOST_ITERATIONS,
            directions: &mut state.directions,
            progress: &mut progress,
            work,
        };
        let outcome = problem.solve(&mut iterate, &mut run);
        track.count();
        counters.seconds.krylov += krylov.elapsed().as_secs_f64();
        state.scales = scales;
        add_scaled(&mut state.displacement, 1.0, &iterate.displacement);
        add_scaled(&mut state.pressure, 1.0, &iterate.equality);
        state.multiplier = iterate.multiplier;
        state.active = iterate.active;
        outcome
    }

    /// Makes `ending` describe the state that is kept.
    pub(super) fn describe(
        &self,
        load: &[f64],
        state: &mut State,
        ending: &mut Ending,
        work: &mut Workspace,
    ) {
        let drive = state.drive.clone();
        let now = self.evaluate(load, state, &drive, work);
        ending.force_scale = now.force_scale(0.0);
        ending.max_penetration = now.max_penetration;
        ending.residuals = residuals(state, &now, 0.0);
    }
}
