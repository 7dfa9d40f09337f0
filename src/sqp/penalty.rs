//! The volume penalty of rubber: when a larger one is brought in, and how:
//!
//! ```text
//! s mu / 2 int (J - 1 + p / K)^2 dV
//! ```
//!
//! zero in the exact solution; s in shear moduli (decision 22).

use super::attempt::attempt;
use super::diagnosis::is_soft;
use super::run::Run;
use super::step_control::{KeptState, Parts};
use crate::model::ending::Ending;
use crate::report::{Cause, Termination};

/// Failures of one part after another that bring the volume term in.
const PATIENCE: u32 = 2;
/// The same with friction, where no certificate says that a state is soft: the iterations stop
/// where it is, and smaller parts only come nearer.
const PATIENCE_WITH_FRICTION: u32 = 1;
/// First shares of a penalty: what the pair has moved wrongly comes back by degrees.
const GENTLE: [f64; 2] = [0.0625, 0.25];

/// The weight of the volume penalty where less of it may be what loses the
/// equilibrium.
pub(crate) fn next_penalty(run: &Run<'_>, ending: &Ending, parts: &Parts) -> Option<f64> {
    if run.model.plan.never_takes_a_penalty() {
        return None;
    }
    let patience = match run.model.interfaces.friction {
        Some(_) => PATIENCE_WITH_FRICTION,
        None => PATIENCE,
    };
    let is_lost = ending.cause == Some(Cause::UnstableEquilibrium)
        || is_soft(run)
        || parts.failures >= patience;
    let pressures = run.state.pressure.iter();
    let largest = pressures.fold(0.0, |most: f64, p| most.max(p.abs()));
    let present = run.state.penalty.max(parts.tried);
    let weight = run.model.plan.next_penalty(present, largest);
    weight.filter(|_| is_lost)
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
