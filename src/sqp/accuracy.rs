//! How far an increment's residuals are reduced: to the scene's tolerance, or
//! until the algebraic error is small beside the discretisation error,
//!
//! ```text
//! r.A^r + c.M^-1 c + sum_i k_i (g_i / w_i)^2 <= (s theta |u| / 10)^2
//! ```
//!
//! so that it is a tenth of it not only in the energy norm: s is the size of the
//! cells, by which the discretisation error in L2 is smaller, and in contact at
//! most theta, for the error of a force is of the order of theta^2.
//! r, c, g: residuals of force, volume and gap; A^ the displacement
//! preconditioner, M the pressure metric, so that the first two terms are squares
//! of energy norms; w_i = int phi_i and k_i the stiffness of a punch of that area
//! (larger than the true one for smooth gaps); theta: [`super::estimate`].
//!
//! Solves to a coarse tolerance, estimates, and goes on from there with the kept
//! directions to the tolerance that follows, until it holds. Cost beside the
//! iterations saved: an estimate and one preconditioner application a round.

use super::counters::Counters;
use super::drive::Drive;
use super::estimate::{Estimate, contact_modulus, estimate, punch_stiffness};
use super::evaluate::{Context, Evaluation, evaluate};
use super::increment::{self, Ending};
use super::state::State;
use super::watch::Watch;
use crate::linalg::vector::dot;
use crate::linalg::{Preconditioner, Workspace};
use crate::report::Termination;
use crate::scene::ToleranceRule;

/// Tolerance of the first round.
const COARSE: f64 = 1e-3;
/// Algebraic over discretisation error, both in the energy norm.
const SHARE: f64 = 0.1;
/// A round lowers the tolerance at least by this factor.
const LEAST_REDUCTION: f64 = 0.5;
/// Aim below what is needed, for what a round does not reduce evenly.
const MARGIN: f64 = 0.8;

/// Moves `state` to equilibrium under `drive`, as accurately as the scene asks.
pub(crate) fn solve(
    context: &Context<'_>,
    state: &mut State,
    drive: &Drive,
    watch: &mut Watch<'_>,
    counters: &mut Counters,
    work: &mut Workspace,
) -> Ending {
    match context.plan.scene.solver.tolerance_rule {
        ToleranceRule::Fixed => increment::solve(context, state, drive, watch, counters, work),
        ToleranceRule::Discretisation => {
            by_discretisation(context, state, drive, watch, counters, work)
        }
    }
}

fn by_discretisation(
    context: &Context<'_>,
    state: &mut State,
    drive: &Drive,
    watch: &mut Watch<'_>,
    counters: &mut Counters,
    work: &mut Workspace,
) -> Ending {
    let floor = context.tolerance;
    let mut level = COARSE.max(floor);
    loop {
        let round = Context {
            tolerance: level,
            ..*context
        };
        let mut ending = increment::solve(&round, state, drive, watch, counters, work);
        if ending.termination != Termination::Converged {
            return ending;
        }
        let estimated = estimate(context, state);
        ending.estimate = Some(estimated);
        counters.applications += 1;
        let algebraic = algebraic_error(context, state, drive, work);
        let allowed = allowed_error(context, state, &estimated);
        if algebraic <= allowed || level <= floor {
            return ending;
        }
        let needed = level * (MARGIN * allowed / algebraic);
        level = needed.min(LEAST_REDUCTION * level).max(floor);
    }
}

/// Algebraic error that neither the L2 norm of u nor the contact forces notice.
fn allowed_error(context: &Context<'_>, state: &State, estimated: &Estimate) -> f64 {
    let dimension = context.plan.units.dimension;
    let volume: f64 = context.prepared.geometry.volumes.iter().sum();
    // A cell's edge, were all cells halves of squares or sixths of cubes.
    let corner_cells = if dimension == 2 { 2.0 } else { 6.0 };
    let cells = context.mesh.cell_count() as f64;
    let size = (corner_cells * volume / cells).powf(1.0 / dimension as f64);
    let finest = match state.active.contains(&true) {
        true => size.min(estimated.relative),
        false => size,
    };
    SHARE * finest * estimated.relative * estimated.norm
}

/// Energy norm of what the residuals leave undone.
fn algebraic_error(
    context: &Context<'_>,
    state: &State,
    drive: &Drive,
    work: &mut Workspace,
) -> f64 {
    let now = evaluate(context, state, drive, work);
    let mut correction = work.zeros(now.force.len());
    let prepared = context.prepared;
    prepared
        .at_rest
        .displacement
        .apply(&now.force, &mut correction, work);
    let mut square = dot(&now.force, &correction);
    work.give(correction);
    if let Some(block) = &prepared.pressure {
        let mut correction = work.zeros(now.constraint.len());
        block.metric.apply(&now.constraint, &mut correction, work);
        square += dot(&now.constraint, &correction);
        work.give(correction);
    }
    (square + gap_square(context, state, &now)).max(0.0).sqrt()
}

/// What springs in the place of the body take to close the wrong gaps.
fn gap_square(context: &Context<'_>, state: &State, now: &Evaluation) -> f64 {
    let mut square = 0.0;
    for (index, interface) in context.interfaces.list.iter().enumerate() {
        let modulus = contact_modulus(context, index);
        let range = interface.range();
        let gaps = now.gap[range.clone()].iter().zip(&state.active[range]);
        for ((&gap, &active), &weight) in gaps.zip(&interface.surface.weights) {
            let wrong = if active { gap } else { gap.min(0.0) };
            let stiffness = punch_stiffness(context.plan.units.dimension, modulus, weight);
            square += stiffness * (wrong / weight).powi(2);
        }
    }
    square
}
