//! The volume penalty of rubber: when a larger one is brought in, and how:
//!
//! ```text
//! s mu / 2 int (J - 1 + p / K)^2 dV
//! ```
//!
//! zero in the exact solution; s in shear moduli (decisions 22 and 45).

use super::checkpoint::Checkpoint;
use super::part::solve_part;
use crate::linalg::LinearOperator;
use crate::linalg::vector::dot;
use crate::model::ending::Ending;
use crate::report::Termination;
use crate::sqp::lowest_mode::LowestMode;
use crate::sqp::program::QuadraticProgram;
use crate::sqp::run::Run;

constants! {
    /// Share of a motion's strain energy that is change of volume between the vertices, from which on
    /// it is one of the mesh: bodies buckle and roll with hardly any.
    const OF_THE_MESH: f64 = 0.45;
    /// First shares of a penalty: what the pair has moved wrongly comes back by degrees.
    const GENTLE: [f64; 2] = [0.0625, 0.25];
}

/// The weight of the volume penalty where less of it may be what loses the equilibrium; `lost` is
/// the motion along which one was seen to be unstable, `tried` the largest weight that led
/// nowhere. Where bodies snap through it has to be that motion which a penalty holds, and hardly
/// any that the body has.
pub(super) fn next_penalty(
    run: &mut Run<'_>,
    lost: Option<&LowestMode>,
    tried: f64,
) -> Option<f64> {
    let pressures = run.state.pressure.iter();
    let largest = pressures.fold(0.0, |most: f64, p| most.max(p.abs()));
    let present = run.state.penalty.max(tried);
    let weight = run.model.plan.next_penalty(present, largest)?;
    let is_needed = !run.model.plan.snaps_through()
        || lost.is_some_and(|mode| is_of_the_mesh(run, mode, weight));
    is_needed.then_some(weight)
}

/// Whether a motion that lowers the energy changes volumes between the vertices so much that the
/// pair of elements lets it go and no body: the penalty `weight` alone would hold it,
///
/// ```text
/// x.K_s x - x.K x >= |l|,   (x.K_s x - x.K x) / s >= share of int 2 eps : eps
/// ```
fn is_of_the_mesh(run: &mut Run<'_>, mode: &LowestMode, weight: f64) -> bool {
    let present = run.state.penalty;
    let held = curvature(run, mode, weight) - curvature(run, mode, present);
    run.state.penalty = present;
    let mut strained = vec![0.0; mode.motion.len()];
    let stiffness = &run.model.prepared.stiffness;
    stiffness.apply(&mode.motion, &mut strained, run.work);
    let strain = dot(&mode.motion, &strained);
    held >= mode.eigenvalue.abs() && held >= OF_THE_MESH * (weight - present) * strain
}

/// x.K x at the present state with the volume penalty `penalty`.
fn curvature(run: &mut Run<'_>, mode: &LowestMode, penalty: f64) -> f64 {
    run.state.penalty = penalty;
    let now = run.evaluate();
    let program = QuadraticProgram::new(run, &now, None, &mut 0.0);
    program.curvature_along(&mode.motion, run.work)
}

/// Moves a good state to where a larger penalty has its equilibrium; leaves it
/// as it was where that is not found.
pub(super) fn penalise(run: &mut Run<'_>, weight: f64) -> Ending {
    let checkpoint = Checkpoint::of(run);
    let drive = run.state.drive.clone();
    let mut shares = GENTLE.into_iter();
    loop {
        let share = shares.next().unwrap_or(1.0);
        run.state.penalty = share * weight;
        run.learned.refresh.renew();
        run.learned.factored = None;
        let ending = solve_part(run, &drive);
        if ending.termination != Termination::Converged {
            checkpoint.restore(run);
            return ending;
        }
        if share >= 1.0 {
            return ending;
        }
    }
}
