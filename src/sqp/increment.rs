//! Solves for equilibrium under one drive by sequential quadratic programs.
//!
//! Each program freezes the normals, keeps the curvature of the gap as a term
//! of the stiffness, and is solved to a fraction of the present residual. The
//! step is halved until a filter on (constraint violation, force residual)
//! accepts it. A flat obstacle needs one program.

use super::constraints::prescribe;
use super::counters::{Counters, timed};
use super::drive::Drive;
use super::evaluate::{Context, Evaluation, evaluate, ratio};
use super::state::State;
use crate::contact::gap::curvature;
use crate::inequality::{
    OneLevel, QpIterate, QpNorms, QpOutcome, QpScales, QpStatus, QpTargets, dense_qp,
};
use crate::krylov::{Monitor, Outcome, Verdict, cg};
use crate::linalg::vector::{add_scaled, dot, norm};
use crate::linalg::{DenseMatrix, LinearOperator, SparseRows, Workspace};
use crate::obstacle::Obstacle;
use crate::precond::compliance::{ComplianceParts, compliance};
use crate::report::{CancelToken, Cause, IterationRecord, Observer, Residuals, Termination};
use crate::saddle::MultiplierBlock;

/// Quadratic programs per increment.
const MOST_PROGRAMS: u32 = 40;
/// Krylov iterations per program.
const MOST_ITERATIONS: u32 = 600;
/// Aim of a program below the tolerance, for what the recomputed residual adds.
const MARGIN: f64 = 0.95;
/// First reduction asked of a program with a curved gap.
const FIRST_REDUCTION: f64 = 1e-2;
/// Halvings of a step.
const MOST_HALVINGS: u32 = 8;
/// Least relative progress in one of the filter's measures.
const LEAST_PROGRESS: f64 = 1e-4;

/// Who watches, and what stops an increment.
pub(crate) struct Watch<'a> {
    pub(crate) observer: &'a mut dyn Observer,
    pub(crate) cancel: &'a CancelToken,
    pub(crate) max_wall_time: Option<f64>,
    pub(crate) record: IterationRecord,
}

/// How an increment ended.
#[derive(Clone, Debug)]
pub(crate) struct Ending {
    pub(crate) termination: Termination,
    pub(crate) cause: Option<Cause>,
    pub(crate) residuals: Residuals,
    pub(crate) max_penetration: f64,
    /// Scale of the equilibrium residual.
    pub(crate) force_scale: f64,
}

/// Moves `state` to equilibrium under `drive`.
pub(crate) fn solve(
    context: &Context<'_>,
    state: &mut State,
    drive: &Drive,
    watch: &mut Watch<'_>,
    counters: &mut Counters,
    work: &mut Workspace,
) -> Ending {
    let displacement = &mut state.displacement;
    prescribe(
        context.plan,
        context.mesh,
        context.prepared,
        drive,
        displacement,
    );
    state.drive = drive.clone();
    let mut now = timed(&mut counters.seconds.contact, || {
        evaluate(context, state, drive, work)
    });
    let first_force = norm(&now.force);
    let mut reduction = FIRST_REDUCTION;
    for _ in 0..MOST_PROGRAMS {
        let worst = residuals(state, &now, first_force).largest();
        if let Some((termination, cause)) = verdict(context, worst, watch, counters) {
            return ending(state, &now, first_force, termination, cause);
        }
        counters.sqp_iterations += 1;
        let program = Program::new(context, state, drive, &now, first_force, counters, work);
        let goal = match context.interfaces.are_flat() {
            true => 0.0,
            false => reduction * worst,
        };
        let (step, outcome) = program.solve(state, &now, goal, watch, counters, work);
        if let Some(ended) = stop_reason(outcome.status, watch) {
            if ended.0 == Termination::NotConverged {
                // The best iterate is kept, and may be good enough after all.
                step.apply(state, 1.0);
                now = evaluate(context, state, drive, work);
                let after = residuals(state, &now, first_force).largest();
                if after <= context.plan.scene.solver.tolerance {
                    continue;
                }
            }
            return ending(state, &now, first_force, ended.0, ended.1);
        }
        let found = search(
            context,
            state,
            drive,
            &step,
            &now,
            first_force,
            counters,
            work,
        );
        let Some(next) = found else {
            let cause = Some(Cause::LineSearch);
            return ending(state, &now, first_force, Termination::NotConverged, cause);
        };
        reduction = forcing(worst, residuals(state, &next, first_force).largest());
        now = next;
    }
    let cause = Some(Cause::IterationLimit);
    ending(state, &now, first_force, Termination::NotConverged, cause)
}

/// Whether the present state ends the increment.
fn verdict(
    context: &Context<'_>,
    worst: f64,
    watch: &Watch<'_>,
    counters: &Counters,
) -> Option<(Termination, Option<Cause>)> {
    if !worst.is_finite() {
        return Some((Termination::NotConverged, Some(Cause::NotFinite)));
    }
    if worst <= context.plan.scene.solver.tolerance {
        return Some((Termination::Converged, None));
    }
    watch
        .stopped(counters)
        .map(|termination| (termination, None))
}

fn ending(
    state: &mut State,
    now: &Evaluation,
    first_force: f64,
    termination: Termination,
    cause: Option<Cause>,
) -> Ending {
    state.force_scale = now.force_scale(first_force);
    Ending {
        termination,
        cause,
        residuals: residuals(state, now, first_force),
        max_penetration: now.max_penetration,
        force_scale: state.force_scale,
    }
}

/// Residuals, after the scales have seen the present norms.
fn residuals(state: &mut State, now: &Evaluation, first_force: f64) -> Residuals {
    let gap = now.gap_norm(&state.active);
    state.scales.see(norm(&now.constraint), gap);
    now.residuals(state, first_force, &state.scales)
}

/// Eisenstat and Walker's second choice: the better the last program predicted,
/// the more is asked of the next.
fn forcing(before: f64, after: f64) -> f64 {
    (0.5 * (after / before).powi(2)).clamp(1e-6, FIRST_REDUCTION)
}

fn stop_reason(status: QpStatus, watch: &Watch<'_>) -> Option<(Termination, Option<Cause>)> {
    let failed = |cause| Some((Termination::NotConverged, Some(cause)));
    match status {
        QpStatus::Solved => None,
        QpStatus::Interrupted => Some((
            watch.cancel.stopped().unwrap_or(Termination::Cancelled),
            None,
        )),
        QpStatus::ActiveSetCycle => failed(Cause::ActiveSetCycle),
        QpStatus::IndefiniteMetric => failed(Cause::IndefiniteTangent),
        QpStatus::Krylov(Outcome::IterationLimit) => failed(Cause::IterationLimit),
        QpStatus::Krylov(Outcome::Stagnation | Outcome::Stopped) => failed(Cause::Stagnation),
        QpStatus::Krylov(Outcome::NotFinite) => failed(Cause::NotFinite),
        QpStatus::Krylov(Outcome::Indefinite) => failed(Cause::IndefiniteTangent),
    }
}

impl Watch<'_> {
    fn report(
        &mut self,
        norms: &QpNorms,
        scales: &QpScales,
        force_scale: f64,
        active: usize,
        counters: &Counters,
    ) {
        self.record.sqp_iteration = counters.sqp_iterations;
        self.record.krylov_iterations = counters.krylov_iterations;
        self.record.preconditioner_applications = counters.krylov_iterations;
        self.record.attempt = counters.cut_backs;
        self.record.active_set_changes = counters.set_changes;
        self.record.active_vertices = active as u32;
        self.record.step_length = counters.step_length;
        self.record.seconds = counters.start.elapsed().as_secs_f64();
        self.record.residuals = Residuals {
            equilibrium: ratio(norms.force, force_scale),
            incompressibility: ratio(norms.constraint, scales.constraint),
            complementarity: 0.0,
            gap: ratio(norms.gap, scales.gap),
        };
        self.observer.iteration(&self.record);
    }

    /// Polls the token and the wall time.
    fn stopped(&self, counters: &Counters) -> Option<Termination> {
        let seconds = counters.start.elapsed().as_secs_f64();
        if self.max_wall_time.is_some_and(|most| seconds > most) {
            self.cancel.expire();
        }
        self.cancel.stopped()
    }
}

/// A step of all unknowns.
struct Step {
    displacement: Vec<f64>,
    pressure: Vec<f64>,
    /// New multipliers minus old ones.
    multiplier: Vec<f64>,
    active: Vec<bool>,
}

impl Step {
    fn apply(&self, state: &mut State, length: f64) {
        add_scaled(&mut state.displacement, length, &self.displacement);
        add_scaled(&mut state.pressure, length, &self.pressure);
        add_scaled(&mut state.multiplier, length, &self.multiplier);
        state.active.copy_from_slice(&self.active);
    }
}

/// A filter line search: the largest step 1, 1/2, 1/4, .. that reduces the
/// constraint violation or the force residual.
#[allow(clippy::too_many_arguments)]
fn search(
    context: &Context<'_>,
    state: &mut State,
    drive: &Drive,
    step: &Step,
    now: &Evaluation,
    first_force: f64,
    counters: &mut Counters,
    work: &mut Workspace,
) -> Option<Evaluation> {
    let old = state.snapshot();
    let start = measures(state, now, first_force);
    let mut length = 1.0;
    for _ in 0..=MOST_HALVINGS {
        step.apply(state, length);
        let trial = timed(&mut counters.seconds.contact, || {
            evaluate(context, state, drive, work)
        });
        let end = measures(state, &trial, first_force);
        let better = end
            .iter()
            .zip(&start)
            .any(|(after, before)| *after <= (1.0 - LEAST_PROGRESS) * before);
        let tolerable = end
            .iter()
            .all(|&m| m <= context.plan.scene.solver.tolerance);
        if context.interfaces.are_flat() || better || tolerable {
            counters.step_length = length;
            return Some(trial);
        }
        length *= 0.5;
        state.restore(&old);
    }
    None
}

/// Constraint violation and force residual.
fn measures(state: &State, now: &Evaluation, first_force: f64) -> [f64; 2] {
    let violation = ratio(now.gap_norm(&state.active), state.scales.gap)
        + ratio(norm(&now.constraint), state.scales.constraint);
    [
        violation,
        ratio(norm(&now.force), now.force_scale(first_force)),
    ]
}

/// One quadratic program.
struct Program<'a> {
    context: Context<'a>,
    curvature: Option<SparseRows>,
    compliance: DenseMatrix,
    force_scale: f64,
}

impl<'a> Program<'a> {
    fn new(
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
                vertices: &context.plan.contact_vertices,
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
    fn solve(
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
                    displacement: &self.context.prepared.displacement,
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
            &self.context.prepared.displacement,
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
