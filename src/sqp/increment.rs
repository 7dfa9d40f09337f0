//! Solves for equilibrium under one drive by sequential quadratic programs.
//!
//! Each program freezes the normals, keeps the curvature of the gap as a term
//! of the stiffness, and is solved to a fraction of the present residual. The
//! step is halved until a filter on (constraint violation, force residual)
//! accepts it. A flat obstacle needs one program.

use super::constraints::prescribe;
use super::counters::{Counters, timed};
use super::drive::Drive;
use super::estimate::Estimate;
use super::evaluate::{Context, Evaluation, evaluate, ratio};
use super::program::{Program, Step};
use super::state::State;
use super::watch::Watch;
use crate::inequality::QpStatus;
use crate::krylov::Outcome;
use crate::linalg::Workspace;
use crate::linalg::vector::norm;
use crate::report::{Cause, Residuals, Termination};

/// Quadratic programs per increment.
const MOST_PROGRAMS: u32 = 40;
/// First reduction asked of a program with a curved gap.
const FIRST_REDUCTION: f64 = 1e-2;
/// Halvings of a step.
const MOST_HALVINGS: u32 = 8;
/// Least relative progress in one of the filter's measures.
const LEAST_PROGRESS: f64 = 1e-4;

/// How an increment ended.
#[derive(Clone, Debug)]
pub(crate) struct Ending {
    pub(crate) termination: Termination,
    pub(crate) cause: Option<Cause>,
    pub(crate) residuals: Residuals,
    pub(crate) max_penetration: f64,
    /// Scale of the equilibrium residual.
    pub(crate) force_scale: f64,
    /// Bound on the residuals that counted.
    pub(crate) tolerance: f64,
    /// Of the discretisation error, where the increment's end depended on it.
    pub(crate) estimate: Option<Estimate>,
}

impl Ending {
    /// Whether something outside the solver ended it.
    pub(crate) fn is_stopped(&self) -> bool {
        match self.termination {
            Termination::Converged | Termination::NotConverged => false,
            Termination::Cancelled | Termination::DeadlineExceeded | Termination::InternalError => {
                true
            }
        }
    }
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
            return ending(
                context.tolerance,
                state,
                &now,
                first_force,
                termination,
                cause,
            );
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
                if after <= context.tolerance {
                    continue;
                }
            }
            return ending(
                context.tolerance,
                state,
                &now,
                first_force,
                ended.0,
                ended.1,
            );
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
            return ending(
                context.tolerance,
                state,
                &now,
                first_force,
                Termination::NotConverged,
                cause,
            );
        };
        reduction = forcing(worst, residuals(state, &next, first_force).largest());
        now = next;
    }
    let cause = Some(Cause::IterationLimit);
    ending(
        context.tolerance,
        state,
        &now,
        first_force,
        Termination::NotConverged,
        cause,
    )
}

/// Makes `ending` describe the state that is kept.
pub(crate) fn describe(
    context: &Context<'_>,
    state: &mut State,
    ending: &mut Ending,
    work: &mut Workspace,
) {
    let drive = state.drive.clone();
    let now = evaluate(context, state, &drive, work);
    ending.force_scale = now.force_scale(0.0);
    ending.max_penetration = now.max_penetration;
    ending.residuals = residuals(state, &now, 0.0);
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
    if worst <= context.tolerance {
        return Some((Termination::Converged, None));
    }
    watch
        .stopped(counters)
        .map(|termination| (termination, None))
}

pub(super) fn ending(
    tolerance: f64,
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
        tolerance,
        estimate: None,
    }
}

/// Residuals, after the scales have seen the present norms.
pub(super) fn residuals(state: &mut State, now: &Evaluation, first_force: f64) -> Residuals {
    let gap = now.gap_norm(&state.active);
    state.scales.see(norm(&now.constraint), gap);
    now.residuals(state, first_force, &state.scales)
}

/// Eisenstat and Walker's second choice: the better the last program predicted,
/// the more is asked of the next.
fn forcing(before: f64, after: f64) -> f64 {
    (0.5 * (after / before).powi(2)).clamp(1e-6, FIRST_REDUCTION)
}

pub(super) fn stop_reason(
    status: QpStatus,
    watch: &Watch<'_>,
) -> Option<(Termination, Option<Cause>)> {
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
        let tolerable = end.iter().all(|&m| m <= context.tolerance);
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
