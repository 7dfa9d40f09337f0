//! What a quadratic program starts from and what it returns: increments of
//! displacement and pressure, the multipliers themselves.
//!
//! A step is `[displacement]`, `[pressures]`, `[multipliers]`, and a status for each
//! multiplier; a length between 0 and 1 scales the numbers and takes the statuses over.

use crate::inequality::{BlockIterate, QpIterate};
use crate::linalg::vector::add_scaled;
use crate::model::evaluate::Evaluation;
use crate::model::prescribed::Motion;
use crate::model::state::State;
use crate::saddle::Status;

/// A step of all unknowns.
pub(crate) struct Step {
    /// Change of the displacement `[displacement]`, the motion of the supports
    /// included.
    pub(crate) displacement: Vec<f64>,
    /// Change of the pressure `[pressures]`.
    pressure: Vec<f64>,
    /// New multipliers minus old ones `[multipliers]`.
    multiplier: Vec<f64>,
    /// What each multiplier does after the step `[multipliers]`.
    status: Vec<Status>,
}

impl Step {
    /// Adds `length` times the step to the state, 1 being the whole step; the statuses
    /// are taken over at any length.
    pub(crate) fn apply(&self, state: &mut State, length: f64) {
        state.move_by(length, &self.displacement);
        add_scaled(&mut state.pressure, length, &self.pressure);
        add_scaled(&mut state.multiplier, length, &self.multiplier);
        state.status.copy_from_slice(&self.status);
    }
}

/// The iterate that a program starts from: the prescribed motion, the residuals after
/// it, and the multipliers of the state.
pub(crate) fn first_iterate(state: &State, now: &Evaluation, motion: Option<&Motion>) -> QpIterate {
    let still = || vec![0.0; state.displacement.len()];
    QpIterate {
        displacement: motion.map_or_else(still, Motion::whole),
        force: now.force.clone(),
        blocks: blocks(
            now.constraint.clone(),
            BlockIterate {
                multiplier: state.multiplier.clone(),
                residual: now.gap.clone(),
                status: state.status.clone(),
                slides: Vec::new(),
            },
        ),
    }
}

/// Of a body with that residual of its pressure, if it has any, and of contact.
pub(crate) fn blocks(constraint: Vec<f64>, contact: BlockIterate) -> Vec<BlockIterate> {
    let pressure = (!constraint.is_empty()).then(|| BlockIterate::of_equality(constraint));
    pressure.into_iter().chain([contact]).collect()
}

/// The step that a solved iterate stands for, from the state at which the program was
/// made.
pub(crate) fn step_from(mut iterate: QpIterate, state: &State) -> Step {
    let contact = iterate.blocks.pop().unwrap_or_default();
    let pressure = iterate.blocks.pop().unwrap_or_default();
    let multiplier = contact.multiplier.iter().zip(&state.multiplier);
    Step {
        multiplier: multiplier.map(|(new, old)| new - old).collect(),
        displacement: iterate.displacement,
        pressure: pressure.multiplier,
        status: contact.status,
    }
}
