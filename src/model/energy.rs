//! Energy of the body, non-dimensional:
//!
//! ```text
//! stored = 1/2 u.(A u) + 1/2 p.(S p)  or  int W + 1/2 p.(S p)
//! ```
//!
//! Cost: one product with the operator.

use super::Model;
use super::internal::Internal;
use super::state::State;
use crate::assembly::grid::Rows;
use crate::linalg::vector::dot;
use crate::linalg::{LinearOperator, Workspace};

/// Stored energy.
pub(crate) fn strain_energy(
    model: &Model<'_>,
    state: &State,
    inside: &Internal,
    work: &mut Workspace,
) -> f64 {
    let mut energy = match inside.response {
        Some(response) => response.energy,
        None => 0.5 * dot(&state.displacement, &inside.force),
    };
    let Some(block) = &model.prepared.pressure else {
        return energy;
    };
    let mut product = work.scratch(state.pressure.len());
    if inside.response.is_none() {
        // u.(B^T p) is taken off again: it vanishes at equilibrium only up to S.
        let grid = &model.prepared.grid;
        grid.divergence(Rows::All, &state.displacement, &mut product, work);
        energy -= 0.5 * dot(&product, &state.pressure);
    }
    if let Some(stabilisation) = &block.stabilisation {
        stabilisation.apply(&state.pressure, &mut product, work);
        energy += 0.5 * dot(&product, &state.pressure);
    }
    work.give(product);
    energy
}
