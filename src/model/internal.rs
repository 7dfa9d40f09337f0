//! Forces and volumes of the body itself at a state, without loads and contact:
//!
//! ```text
//! A u + B^T p,   -(B u - S p)
//! ```
//!
//! or int P : grad v and the volume defect of rubber in their place. Non-dimensional,
//! hierarchical, all rows. Cost: one product with the operator.

use super::Model;
use super::state::State;
use crate::assembly::grid::{Basis, Rows, StiffnessForm, VolumeTerm};
use crate::assembly::strain::Response;
use crate::linalg::vector::add_scaled;
use crate::linalg::{LinearOperator, Workspace};

/// What the body itself brings to the residuals.
#[derive(Clone, Debug)]
pub(crate) struct Internal {
    /// A u + B^T p or what takes its place, all rows.
    pub(crate) force: Vec<f64>,
    /// Residual of the volume constraint, -(B u - S p) `[pressures]`, non-dimensional.
    pub(crate) constraint: Vec<f64>,
    /// Stress, tangent and volume change at the points of rubber; none for linear
    /// bodies.
    pub(crate) response: Option<Response>,
}

/// Forces and volumes of the body at a state.
pub(crate) fn internal(model: &Model<'_>, state: &State, work: &mut Workspace) -> Internal {
    let Some(cells) = state.cells(model.prepared) else {
        return Internal {
            force: linear_force(model, state, work),
            constraint: constraint(model, state, work),
            response: None,
        };
    };
    let mut force = vec![0.0; state.displacement.len()];
    let mut residual = vec![0.0; state.pressure.len()];
    let displacement = state.relative_displacement();
    let fields = (&displacement[..], &state.pressure[..]);
    let response = cells.respond(fields, (&mut force, &mut residual), work);
    finish_constraint(model, state, &mut residual, work);
    Internal {
        force,
        constraint: residual,
        response: Some(response),
    }
}

/// A u + B^T p, all rows.
fn linear_force(model: &Model<'_>, state: &State, work: &mut Workspace) -> Vec<f64> {
    let grid = &model.prepared.grid;
    let mut force = vec![0.0; state.displacement.len()];
    grid.stiffness(
        StiffnessForm {
            basis: Basis::Hierarchical,
            rows: Rows::All,
            volume: VolumeTerm::Own,
        },
        &state.displacement,
        &mut force,
        work,
    );
    if !state.pressure.is_empty() {
        let mut part = work.scratch(force.len());
        grid.divergence_transposed(Rows::All, &state.pressure, &mut part, work);
        add_scaled(&mut force, 1.0, &part);
        work.give(part);
    }
    force
}

/// -(B u - S p).
fn constraint(model: &Model<'_>, state: &State, work: &mut Workspace) -> Vec<f64> {
    let mut residual = vec![0.0; state.pressure.len()];
    if !residual.is_empty() {
        let grid = &model.prepared.grid;
        grid.divergence(Rows::All, &state.displacement, &mut residual, work);
        finish_constraint(model, state, &mut residual, work);
    }
    residual
}

/// From B u to -(B u - S p).
fn finish_constraint(model: &Model<'_>, state: &State, residual: &mut [f64], work: &mut Workspace) {
    residual.iter_mut().for_each(|value| *value = -*value);
    let block = model.prepared.pressure.as_ref();
    if let Some(stabilisation) = block.and_then(|block| block.stabilisation.as_ref()) {
        let mut product = work.scratch(residual.len());
        stabilisation.apply(&state.pressure, &mut product, work);
        add_scaled(residual, 1.0, &product);
        work.give(product);
    }
}
