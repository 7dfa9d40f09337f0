//! The mean of a pressure that nothing fixes: `int p dx = 0`. Cost: a product with the mass.

use super::Model;
use super::state::State;
use crate::linalg::vector::{add_scaled, dot};
use crate::linalg::{LinearOperator, Workspace};

/// The weights of vertices, `int phi_i dx` over the metric of the pressure, in a body whose pressure
/// is fixed up to a constant; none of others.
fn weights(model: &Model<'_>) -> Option<Vec<f64>> {
    let block = model.prepared.pressure.as_ref()?;
    let mass = block.is_enclosed.then(|| block.metric.mass())?;
    let ones = vec![1.0; mass.rows()];
    let mut weights = vec![0.0; ones.len()];
    mass.apply(&ones, &mut weights, &mut Workspace::new());
    Some(weights)
}

/// An enclosed incompressible body fixes its pressure up to a constant:
/// the mean is set to zero.
pub(crate) fn centre_pressure(model: &Model<'_>, state: &mut State) {
    let Some(weights) = weights(model) else {
        return;
    };
    let mean = dot(&weights, &state.pressure) / weights.iter().sum::<f64>();
    state.pressure.iter_mut().for_each(|p| *p -= mean);
}

/// Takes off `constraint` the volume that the motion of the whole surface asks for to first order:
/// no motion inside gives it, and a surface that turns by a finite angle asks for none in the end.
/// What the surface does ask for is left in the residual of the state that it has moved to.
pub(crate) fn balance_volumes(model: &Model<'_>, constraint: &mut [f64]) {
    let Some(weights) = weights(model) else {
        return;
    };
    let share = constraint.iter().sum::<f64>() / weights.iter().sum::<f64>();
    add_scaled(constraint, -share, &weights);
}
