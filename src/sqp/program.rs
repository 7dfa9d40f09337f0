//! One quadratic program: the body with frozen normals, the curvature of the
//! gap in its stiffness, and the compliance of the candidate surface.

use super::counters::{Counters, timed};
use super::drive::Drive;
use super::evaluate::{Context, Evaluation};
use super::state::State;
use super::watch::Watch;
use crate::contact::gap::curvature;
use crate::inequality::{
    OneLevel, QpIterate, QpNorms, QpOutcome, QpScales, QpStatus, QpTargets, dense_qp,
};
use crate::krylov::{Monitor, Outcome, Verdict, cg};
use crate::linalg::vector::{add_scaled, dot, norm};
use crate::linalg::{DenseMatrix, LinearOperator, SparseRows, Workspace};
use crate::obstacle::Obstacle;
use crate::precond::compliance::{ComplianceParts, compliance};
use crate::precond::p1::Traces;
use crate::saddle::MultiplierBlock;

/// Krylov iterations per program.
const MOST_ITERATIONS: u32 = 600;
/// Aim of a program below the tolerance, for what the recomputed residual adds.
const MARGIN: f64 = 0.95;

/// A step of all unknowns.
pub(super) struct Step {
    pub(super) displacement: Vec<f64>,
    pressure: Vec<f64>,
    /// New multipliers minus old ones.
    multiplier: Vec<f64>,
    active: Vec<bool>,
}

impl Step {
    pub(super) fn apply(&self, state: &mut State, length: f64) {
        add_scaled(&mut state.displacement, length, &self.displacement);
        add_scaled(&mut state.pressure, length, &self.pressure);
        add_scaled(&mut state.multiplier, length, &self.multiplier);
        state.active.copy_from_slice(&self.active);
    }
}

/// One quadratic program.
pub(super) struct Program<'a> {
    context: Context<'a>,
    curvature: Option<SparseRows>,
    compliance: DenseMatrix,
    force_scale: f64,
}

impl<'a> Program<'a> {
    #[allow(clippy::too_many_arguments)]
    pub(super) fn new(
        context: &Context<'a>,
        state: &State,
        drive: &Drive,
        now: &Evaluation,
        first_force: f64,
        counters: &mut Counters,
        work: &mut Workspace,
    ) -> Self {
        timed(&mut counters.seconds.contact, || {
            let parts = ComplianceParts {
                vertex_inverse: &context.prepared.compliance,
                traces: Traces {
                    vertices: &context.plan.contact_vertices,
                    directions: &context.prepared.contact_normals,
                },
                node_blocks: &context.prepared.node_blocks,
                vertex_count: context.prepared.space.vertices,
            };
            let compliance = compliance(&parts, &now.coupling);
            let expected = expected_contact_norm(&compliance, now, state, work);
            Self {
                context: *context,
                curvature: curvature_of(context, state, drive),
                compliance,
                force_scale: now.force_scale(first_force).max(expected),
            }
        })
    }

    /// The tolerance, or `goal` where the gap is curved.
    fn targets(&self, goal: f64) -> QpTargets {
        QpTargets {
            force_scale: self.force_scale,
            level: goal.max(MARGIN * self.context.plan.scene.solver.tolerance),
        }
    }

    /// Solves the program; without the curvature term where it fails or the
    /// step has no positive stiffness with it.
    pub(super) fn solve(
        &self,
        state: &mut State,
        now: &Evaluation,
        goal: f64,
        watch: &mut Watch<'_>,
        counters: &mut Counters,
        work: &mut Workspace,
    ) -> (Step, QpOutcome) {
        if let Some(curvature) = &self.curvature {
            let solved = self.solve_with(Some(curvature), state, now, goal, watch, counters, work);
            let failed = matches!(solved.1.status, QpStatus::Krylov(_));
            if !failed && self.has_positive_stiffness(curvature, &solved.0.displacement, work) {
                return solved;
            }
        }
        self.solve_with(None, state, now, goal, watch, counters, work)
    }

    #[allow(clippy::too_many_arguments)]
    fn solve_with(
        &self,
        curvature: Option<&SparseRows>,
        state: &mut State,
        now: &Evaluation,
        goal: f64,
        watch: &mut Watch<'_>,
        counters: &mut Counters,
        work: &mut Workspace,
    ) -> (Step, QpOutcome) {
        let targets = self.targets(goal);
        let mut scales = state.scales;
        let mut iterate = first_iterate(state, now);
        let krylov = std::time::Instant::now();
        let mut progress = |norms: &QpNorms, scales: &QpScales, active: usize| {
            counters.krylov_iterations += 1;
            watch.report(norms, scales, targets.force_scale, active, counters);
            match watch.stopped(counters) {
                Some(_) => Verdict::Stop,
                None => Verdict::Continue,
            }
        };
        let outcome = match self.context.prepared.pressure.is_none() && now.gap.is_empty() {
            true => self.solve_plain(&mut iterate, &targets, &mut progress, work),
            false => {
                let blocks = self.blocks();
                let problem = OneLevel {
                    stiffness: &self.context.prepared.stiffness,
                    curvature,
                    displacement: &*self.context.prepared.displacement,
                    equality: &blocks,
                    coupling: &now.coupling,
                    compliance: &self.compliance,
                };
                let most = MOST_ITERATIONS;
                let directions = &mut state.directions;
                let scales = &mut scales;
                problem.solve(
                    &mut iterate,
                    &targets,
                    scales,
                    most,
                    directions,
                    &mut progress,
                    work,
                )
            }
        };
        counters.seconds.krylov += krylov.elapsed().as_secs_f64();
        counters.set_changes += outcome.set_changes;
        counters.predictions += outcome.predictions;
        state.scales = scales;
        (step_from(iterate, state), outcome)
    }

    fn has_positive_stiffness(
        &self,
        curvature: &SparseRows,
        step: &[f64],
        work: &mut Workspace,
    ) -> bool {
        let mut product = work.scratch(step.len());
        self.context
            .prepared
            .stiffness
            .apply(step, &mut product, work);
        let stiff = dot(step, &product);
        curvature.apply(step, &mut product, work);
        let released = dot(step, &product);
        work.give(product);
        stiff >= released
    }

    fn blocks(&self) -> Vec<MultiplierBlock<'_>> {
        let pressure = self.context.prepared.pressure.iter();
        pressure
            .map(|block| MultiplierBlock {
                coupling: &block.coupling,
                stabilisation: block
                    .stabilisation
                    .as_ref()
                    .map(|s| s as &dyn LinearOperator),
                metric: &block.metric,
                joint: Some(&block.body),
            })
            .collect()
    }

    /// Displacement only: conjugate gradients.
    fn solve_plain(
        &self,
        iterate: &mut QpIterate,
        targets: &QpTargets,
        progress: &mut dyn FnMut(&QpNorms, &QpScales, usize) -> Verdict,
        work: &mut Workspace,
    ) -> QpOutcome {
        let mut monitor = PlainMonitor {
            targets: *targets,
            progress,
            iterations: 0,
            reached: false,
        };
        let outcome = cg::solve(
            &self.context.prepared.stiffness,
            &*self.context.prepared.displacement,
            &mut iterate.displacement,
            &mut iterate.force,
            MOST_ITERATIONS as usize,
            &mut monitor,
            work,
        );
        let status = match outcome {
            Outcome::Stopped if monitor.reached => QpStatus::Solved,
            Outcome::Stopped => QpStatus::Interrupted,
            Outcome::IterationLimit
            | Outcome::Stagnation
            | Outcome::NotFinite
            | Outcome::Indefinite => QpStatus::Krylov(outcome),
        };
        QpOutcome {
            status,
            iterations: monitor.iterations,
            predictions: 0,
            set_changes: 0,
        }
    }
}

struct PlainMonitor<'a> {
    targets: QpTargets,
    progress: &'a mut dyn FnMut(&QpNorms, &QpScales, usize) -> Verdict,
    iterations: u32,
    reached: bool,
}

impl Monitor for PlainMonitor<'_> {
    fn judge(&mut self, residual: &[f64]) -> Verdict {
        self.iterations += 1;
        let norms = QpNorms {
            force: norm(residual),
            ..QpNorms::default()
        };
        let scales = QpScales::default();
        self.reached = norms.relative(self.targets.force_scale, &scales) <= self.targets.level;
        match (self.progress)(&norms, &scales, 0) {
            Verdict::Continue if !self.reached => Verdict::Continue,
            Verdict::Continue | Verdict::Stop => Verdict::Stop,
        }
    }
}

fn first_iterate(state: &State, now: &Evaluation) -> QpIterate {
    QpIterate {
        displacement: vec![0.0; state.displacement.len()],
        equality: vec![0.0; state.pressure.len()],
        multiplier: state.multiplier.clone(),
        force: now.force.clone(),
        constraint: now.constraint.clone(),
        gap: now.gap.clone(),
        active: state.active.clone(),
    }
}

fn step_from(iterate: QpIterate, state: &State) -> Step {
    let multiplier = iterate.multiplier.iter().zip(&state.multiplier);
    Step {
        multiplier: multiplier.map(|(new, old)| new - old).collect(),
        displacement: iterate.displacement,
        pressure: iterate.equality,
        active: iterate.active,
    }
}

/// Curvature of the gaps under the present contact pressure; none where it
/// vanishes.
fn curvature_of(context: &Context<'_>, state: &State, drive: &Drive) -> Option<SparseRows> {
    let under_pressure = state.multiplier.iter().any(|&l| l != 0.0);
    if context.interfaces.are_flat() || !under_pressure {
        return None;
    }
    let obstacles = context
        .interfaces
        .obstacles(drive, context.plan.units.length);
    let list = context.interfaces.list.iter();
    let surfaces: Vec<_> = list
        .zip(&obstacles)
        .map(|(interface, obstacle)| {
            let pressure = &state.multiplier[interface.range()];
            (&interface.surface, obstacle as &dyn Obstacle, pressure)
        })
        .collect();
    let body = context.deformed(&state.displacement);
    Some(curvature(&body, &surfaces, &context.prepared.is_held))
}

/// Norm of the contact load that the compliance predicts; the scale of the
/// force residual before any contact pressure is there.
fn expected_contact_norm(
    compliance: &DenseMatrix,
    now: &Evaluation,
    state: &State,
    work: &mut Workspace,
) -> f64 {
    let mut linear = vec![0.0; now.gap.len()];
    compliance.multiply(&state.multiplier, &mut linear);
    linear
        .iter_mut()
        .zip(&now.gap)
        .for_each(|(q, gap)| *q = gap - *q);
    let Ok(solution) = dense_qp::solve(compliance, &linear, &state.active) else {
        return 0.0;
    };
    let mut load = vec![0.0; state.displacement.len()];
    now.coupling
        .apply_transposed(&solution.values, &mut load, work);
    norm(&load)
}
