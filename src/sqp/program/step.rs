//! What a quadratic program starts from and what it returns: increments of
//! displacement and pressure, the multipliers themselves.

use super::super::evaluate::Evaluation;
use super::super::state::State;
use crate::inequality::QpIterate;
use crate::linalg::vector::add_scaled;

/// A step of all unknowns.
pub(in crate::sqp) struct Step {
    pub(in crate::sqp) displacement: Vec<f64>,
    pressure: Vec<f64>,
    /// New multipliers minus old ones.
    multiplier: Vec<f64>,
    active: Vec<bool>,
}

impl Step {
    pub(in crate::sqp) fn apply(&self, state: &mut State, length: f64) {
        add_scaled(&mut state.displacement, length, &self.displacement);
        add_scaled(&mut state.pressure, length, &self.pressure);
        add_scaled(&mut state.multiplier, length, &self.multiplier);
        state.active.copy_from_slice(&self.active);
    }
}

pub(super) fn first_iterate(state: &State, now: &Evaluation, motion: Option<&[f64]>) -> QpIterate {
    let still = || vec![0.0; state.displacement.len()];
    QpIterate {
        displacement: motion.map_or_else(still, <[f64]>::to_vec),
        equality: vec![0.0; state.pressure.len()],
        multiplier: state.multiplier.clone(),
        force: now.force.clone(),
        constraint: now.constraint.clone(),
        gap: now.gap.clone(),
        active: state.active.clone(),
    }
}

pub(super) fn step_from(iterate: QpIterate, state: &State) -> Step {
    let multiplier = iterate.multiplier.iter().zip(&state.multiplier);
    Step {
        multiplier: multiplier.map(|(new, old)| new - old).collect(),
        displacement: iterate.displacement,
        pressure: iterate.equality,
        active: iterate.active,
    }
}
