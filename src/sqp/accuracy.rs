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
//! preconditioner, M the pressure metric, both with what they are augmented by taken back, so that the first two terms are squares
//! of energy norms; w_i = int phi_i and k_i the stiffness of a punch of that area
//! (larger than the true one for smooth gaps); theta: [`crate::results::estimate`].
//!
//! Solves to a coarse tolerance, estimates, and goes on from there with the kept
//! directions to the tolerance that follows, until it holds. Cost beside the
//! iterations saved: an estimate and one preconditioner application a round.

use super::increment::describe;
use super::proximal_rest;
use super::run::Run;
use crate::linalg::Preconditioner;
use crate::linalg::vector::dot;
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::ending::{Ending, Estimate};
use crate::model::evaluate::Evaluation;
use crate::model::state::State;
use crate::report::Termination;
use crate::results::estimate::{contact_modulus, estimate, punch_stiffness};
use crate::saddle::SetPoint;
use crate::scene::ToleranceRule;

constants! {
    /// Tolerance of the first round.
    const COARSE: f64 = 1e-3;
    /// Forces at the start over those at hand between which a solve is repeated; chosen: a sleeve of
    /// 1e5 lies between, and beyond the second the body moves as a rigid one, without forces.
    const LARGER: [f64; 2] = [300.0, 1e8];
    /// Algebraic over discretisation error, both in the energy norm.
    const SHARE: f64 = 0.1;
    /// A round lowers the tolerance at least by this factor.
    const LEAST_REDUCTION: f64 = 0.5;
    /// Aim below what is needed, for what a round does not reduce evenly: of what is left, smooth
    /// errors weigh most in L2.
    const MARGIN: f64 = 0.3;
}

/// Moves the state to equilibrium under `drive`, as accurately as the scene asks.
pub(crate) fn solve(run: &mut Run<'_>, drive: &Drive) -> Ending {
    match run.model.plan.problem.settings.tolerance_rule {
        ToleranceRule::Fixed => by_forces(run, drive),
        ToleranceRule::Discretisation => by_discretisation(run, drive),
    }
}

/// Solves to the scene's tolerance of the forces at hand: a stiff part that its support moves begins
/// with forces as much larger as it is stiffer, beside which those of the soft body are rounding. A
/// solve from where the first one ends is measured by the forces there.
fn by_forces(run: &mut Run<'_>, drive: &Drive) -> Ending {
    let moves =
        run.state.drive.supports != drive.supports || run.state.drive.motions != drive.motions;
    let ending = proximal_rest::solve(run, drive);
    if !moves || ending.termination != Termination::Converged || !is_measured_by_more(run, &ending)
    {
        return ending;
    }
    let kept = run.state.clone();
    let mut again = proximal_rest::solve(run, drive);
    if again.termination == Termination::Converged {
        // Told by the measure of the increment, which rounding of its stiff part belongs to.
        run.state.force_scale = ending.force_scale;
        describe(run, &mut again);
        return again;
    }
    if again.is_stopped() {
        return again;
    }
    *run.state = kept;
    ending
}

/// Whether an increment was measured by forces far above those of the state.
fn is_measured_by_more(run: &mut Run<'_>, ending: &Ending) -> bool {
    let forces = run.evaluate().force_scale(0.0);
    let ratio = ending.force_scale / forces;
    (LARGER[0]..LARGER[1]).contains(&ratio)
}

/// Solves to a coarse bound first and lowers it until the algebraic error is small
/// beside the estimated discretisation error, or the floor is met.
fn by_discretisation(run: &mut Run<'_>, drive: &Drive) -> Ending {
    let floor = run.model.conditions.tolerance;
    let mut level = COARSE.max(floor);
    loop {
        let mut ending = proximal_rest::solve(&mut run.to(level), drive);
        if ending.termination != Termination::Converged {
            return ending;
        }
        let estimated = estimate(&run.model, run.state);
        ending.estimate = Some(estimated.clone());
        run.counters.applications += 1;
        let algebraic = algebraic_error(run);
        let allowed = allowed_error(&run.model, run.state, &estimated);
        if algebraic <= allowed || level <= floor {
            return ending;
        }
        let needed = level * (MARGIN * allowed / algebraic);
        level = needed.min(LEAST_REDUCTION * level).max(floor);
    }
}

/// Algebraic error that neither the L2 norm of u nor the contact forces notice.
fn allowed_error(model: &Model<'_>, state: &State, estimated: &Estimate) -> f64 {
    let dimension = model.plan.problem.units.dimension;
    let volume: f64 = model.prepared.geometry.volumes.iter().sum();
    // A cell's edge, were all cells halves of squares or sixths of cubes.
    let corner_cells = if dimension == 2 { 2.0 } else { 6.0 };
    let cells = model.mesh.cell_count() as f64;
    let size = (corner_cells * volume / cells).powf(1.0 / dimension as f64);
    let finest = if state.status.iter().any(|status| status.is_closed()) {
        size.min(estimated.relative)
    } else {
        size
    };
    SHARE * finest * estimated.relative * estimated.norm
}

/// Energy norm of what the residuals leave undone.
fn algebraic_error(run: &mut Run<'_>) -> f64 {
    let now = run.evaluate();
    let (prepared, work) = (run.model.prepared, &mut run.work);
    let mut correction = work.zeros(now.force.len());
    let inverse = &prepared.at_rest.displacement;
    inverse.apply(&now.force, &mut correction, work);
    let plan = run.model.plan;
    // The term that the inverse holds beside A makes it smaller by this for motions along their
    // own gradient, by nothing for those that keep their volume.
    let augmented = 1.0 + 0.5 * plan.augmentation();
    let mut square = augmented * dot(&now.force, &correction);
    work.give(correction);
    if let Some(block) = &prepared.pressure {
        let mut correction = work.zeros(now.constraint.len());
        block.metric.apply(&now.constraint, &mut correction, work);
        let share = plan.augmented_share(plan.augmentation());
        square += share * share * dot(&now.constraint, &correction);
        work.give(correction);
    }
    let square = square + gap_square(&run.model, run.state, &now);
    square.max(0.0).sqrt()
}

/// What springs in the place of the body take to close the wrong gaps.
fn gap_square(model: &Model<'_>, state: &State, now: &Evaluation) -> f64 {
    let wrong = now.contact_set().misfit(SetPoint {
        multiplier: &state.multiplier,
        residual: &now.gap,
        status: &state.status,
    });
    let mut square = 0.0;
    for interface in &model.interfaces.list {
        let modulus = contact_modulus(model, interface);
        let wrong = interface.own(&wrong);
        for (&wrong, &weight) in wrong.iter().zip(&interface.surface.weights) {
            let stiffness = punch_stiffness(model.plan.problem.units.dimension, modulus, weight);
            square += stiffness * (wrong / weight).powi(2);
        }
    }
    square
}
