//! Solves for equilibrium under one drive by sequential quadratic programs.
//!
//! Each program freezes the normals, keeps the curvature of the gap as a term
//! of the stiffness, and is solved to a fraction of the present residual. A
//! linear body before a flat obstacle needs one program. Supports of a linear
//! body jump to where they shall be; those of rubber move with the step, so that
//! the body follows and no element is turned inside out beside them.

use super::constraints::prescribe;
use super::counters::{Counters, timed};
use super::drive::Drive;
use super::estimate::Estimate;
use super::evaluate::{Context, Evaluation, evaluate};
use super::predictor;
use super::program::Program;
use super::search::{Refused, search};
use super::state::State;
use super::watch::Watch;
use crate::inequality::QpStatus;
use crate::krylov::Outcome;
use crate::linalg::Workspace;
use crate::linalg::vector::norm;
use crate::report::{Cause, Residuals, Stability, Termination};

/// Quadratic programs per increment.
const MOST_PROGRAMS: u32 = 40;
/// Share of the residual that a program may leave which did not end.
const WORTHWHILE: f64 = 0.1;
/// First reduction asked of a program with a curved gap.
const FIRST_REDUCTION: f64 = 1e-2;

/// Motion of a support, over the body's length, that rounding leaves.
const SETTLED: f64 = 1e-14;

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
    /// Of a certified equilibrium.
    pub(crate) stability: Option<Stability>,
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
    let (mut now, mut first_force) = start(context, state, drive, counters, work);
    let mut reduction = FIRST_REDUCTION;
    for _ in 0..MOST_PROGRAMS {
        let motion = remaining_motion(context, state, drive);
        let worst = residuals(state, &now, first_force).largest();
        let still = motion.is_none();
        if let Some((termination, cause)) = verdict(context, worst, still, watch, counters) {
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
        let made = counters.factorisations;
        let program = Program::new(
            context,
            state,
            drive,
            (&now, motion),
            &mut first_force,
            watch,
            counters,
            work,
        );
        let worst = residuals(state, program.start(), first_force).largest();
        let goal = match context.is_linear() {
            true => 0.0,
            false => reduction * worst,
        };
        let before = counters.applications;
        let (step, outcome) = program.solve(state, goal, watch, counters, work);
        if context.prepared.strain.is_some() {
            let reached = goal.max(context.tolerance);
            state
                .upkeep
                .note(counters.applications - before, worst, reached);
        }
        if let Some(ended) = stop_reason(outcome.status, watch) {
            if ended.0 == Termination::NotConverged
                && context.prepared.strain.is_some()
                && state.upkeep.failed(counters.factorisations > made)
            {
                // The same program again, with an inverse of its own.
                continue;
            }
            if ended.0 == Termination::NotConverged {
                // The best iterate is kept, and may be good enough after all.
                step.apply(state, 1.0);
                now = evaluate(context, state, drive, work);
                let after = residuals(state, &now, first_force).largest();
                if after <= context.tolerance || serves(context, &now, after / worst) {
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
            program.start(),
            first_force,
            counters,
            work,
        );
        let next = match found {
            Ok(next) => next,
            Err(refused) => {
                return ending(
                    context.tolerance,
                    state,
                    &now,
                    first_force,
                    Termination::NotConverged,
                    Some(match refused {
                        Refused::Jacobian => Cause::NegativeJacobian,
                        Refused::Progress => Cause::LineSearch,
                    }),
                );
            }
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

/// Whether a step of rubber whose program did not end brought enough for another.
fn serves(context: &Context<'_>, now: &Evaluation, share: f64) -> bool {
    let is_right_side_out = now.least_jacobian.is_some_and(|least| least > 0.0);
    context.prepared.strain.is_some() && is_right_side_out && share <= WORTHWHILE
}

/// Moves `state` to where the first program starts; what holds there, and the force
/// that is out of balance before.
fn start(
    context: &Context<'_>,
    state: &mut State,
    drive: &Drive,
    counters: &mut Counters,
    work: &mut Workspace,
) -> (Evaluation, f64) {
    if context.prepared.strain.is_some() {
        return predictor::start(context, state, drive, counters, work);
    }
    let displacement = &mut state.displacement;
    prescribe(
        context.plan,
        context.mesh,
        context.prepared,
        drive,
        displacement,
    );
    state.drive = drive.clone();
    let now = timed(&mut counters.seconds.contact, || {
        evaluate(context, state, drive, work)
    });
    let force = norm(&now.force);
    (now, force)
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
    // That of the increment which led there.
    let known = state.force_scale;
    ending.force_scale = now.force_scale(known);
    ending.max_penetration = now.max_penetration;
    ending.residuals = residuals(state, &now, known);
}

/// How far held entries still are from where `drive` wants them; none where they
/// are there, and always for linear bodies.
pub(super) fn remaining_motion(
    context: &Context<'_>,
    state: &State,
    drive: &Drive,
) -> Option<Vec<f64>> {
    context.prepared.strain.as_ref()?;
    let mut goal = state.displacement.clone();
    prescribe(
        context.plan,
        context.mesh,
        context.prepared,
        drive,
        &mut goal,
    );
    let mut motion = vec![0.0; goal.len()];
    for &index in context.prepared.held.iter() {
        motion[index as usize] = goal[index as usize] - state.displacement[index as usize];
    }
    let largest = motion.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    (largest > SETTLED).then_some(motion)
}

/// Whether the present state ends the increment.
fn verdict(
    context: &Context<'_>,
    worst: f64,
    still: bool,
    watch: &Watch<'_>,
    counters: &Counters,
) -> Option<(Termination, Option<Cause>)> {
    if !worst.is_finite() {
        return Some((Termination::NotConverged, Some(Cause::NotFinite)));
    }
    if worst <= context.tolerance && still {
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
        stability: None,
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
