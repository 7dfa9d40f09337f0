//! The mean of a pressure that nothing fixes: `int p dx = 0`. Cost: a product with the mass.

use super::Model;
use super::state::State;
use crate::linalg::vector::dot;
use crate::linalg::{LinearOperator, Workspace};

/// An enclosed incompressible body fixes its pressure up to a constant:
/// the mean is set to zero.
pub(crate) fn centre_pressure(model: &Model<'_>, state: &mut State) {
    let block = model.prepared.pressure.as_ref();
    let Some(block) = block.filter(|block| block.is_enclosed) else {
        return;
    };
    let mut weights = vec![0.0; state.pressure.len()];
    let ones = vec![1.0; weights.len()];
    let mass = block.metric.mass();
    mass.apply(&ones, &mut weights, &mut Workspace::new());
    let mean = dot(&weights, &state.pressure) / weights.iter().sum::<f64>();
    state.pressure.iter_mut().for_each(|p| *p -= mean);
}
