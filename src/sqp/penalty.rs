//! The volume penalty of rubber: when a larger one is brought in, and how:
//!
//! ```text
//! s mu / 2 int (J - 1 + p / K)^2 dV
//! ```
//!
//! zero in the exact solution; s in shear moduli (decisions 22 and 45).

use super::attempt::attempt;
use super::diagnosis::is_soft;
use super::lowest_mode::LowestMode;
use super::program::QuadraticProgram;
use super::run::Run;
use super::step_control::{KeptState, Parts};
use crate::linalg::LinearOperator;
use crate::linalg::vector::dot;
use crate::model::ending::Ending;
use crate::report::{Cause, Termination};

/// Failures of one part after another that bring the volume term in.
const PATIENCE: u32 = 2;
/// The same with friction, where no certificate says that a state is soft: the iterations stop
/// where it is, and smaller parts only come nearer.
const PATIENCE_WITH_FRICTION: u32 = 1;
/// Share of a motion's strain energy that is change of volume between the vertices, from which on
/// it is one of the mesh: bodies buckle and roll with hardly any.
const OF_THE_MESH: f64 = 0.45;
/// First shares of a penalty: what the pair has moved wrongly comes back by degrees.
const GENTLE: [f64; 2] = [0.0625, 0.25];

/// The weight of the volume penalty where less of it may be what loses the equilibrium; `lost` is
/// the motion along which one was seen to be unstable. Where bodies fall it has to be that motion
/// which a penalty holds, and hardly any that the body has.
pub(crate) fn next_penalty(
    run: &mut Run<'_>,
    (ending, lost): (&Ending, Option<&LowestMode>),
    parts: &Parts,
) -> Option<f64> {
    let pressures = run.state.pressure.iter();
    let largest = pressures.fold(0.0, |most: f64, p| most.max(p.abs()));
    let present = run.state.penalty.max(parts.tried);
    let weight = run.model.plan.next_penalty(present, largest)?;
    let is_needed = match run.model.plan.falls() {
        true => lost.is_some_and(|mode| is_of_the_mesh(run, mode, weight)),
        false => is_lost(run, ending, parts),
    };
    is_needed.then_some(weight)
}

/// Whether an equilibrium is lost, by all that is known of it.
fn is_lost(run: &Run<'_>, ending: &Ending, parts: &Parts) -> bool {
    let patience = match run.model.interfaces.friction {
        Some(_) => PATIENCE_WITH_FRICTION,
        None => PATIENCE,
    };
    ending.cause == Some(Cause::UnstableEquilibrium) || is_soft(run) || parts.failures >= patience
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
    stiffness.apply(&mode.motion, &mut strained, &mut run.work);
    let strain = dot(&mode.motion, &strained);
    held >= mode.eigenvalue.abs() && held >= OF_THE_MESH * (weight - present) * strain
}

/// x.K x at the present state with the volume penalty `penalty`.
fn curvature(run: &mut Run<'_>, mode: &LowestMode, penalty: f64) -> f64 {
    run.state.penalty = penalty;
    let now = run.evaluate();
    let program = QuadraticProgram::new(run, &now, None, &mut 0.0);
    program.curvature_along(&mode.motion, &mut run.work)
}

/// Moves a good state to where a larger penalty has its equilibrium; leaves it
/// as it was where that is not found.
pub(crate) fn penalise(run: &mut Run<'_>, weight: f64) -> Ending {
    let kept = KeptState::of(run);
    let drive = run.state.drive.clone();
    let mut shares = GENTLE.into_iter();
    loop {
        let share = shares.next().unwrap_or(1.0);
        run.state.penalty = share * weight;
        run.learned.refresh.renew();
        run.learned.factored = None;
        let ending = attempt(run, &drive);
        if ending.termination != Termination::Converged {
            kept.restore(run);
            return ending;
        }
        if share >= 1.0 {
            return ending;
        }
    }
}
