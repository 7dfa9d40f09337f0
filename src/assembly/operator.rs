//! The grid's passes as linear operators on eliminated systems: rows and
//! columns of held unknowns are zero in the stiffness and the divergence;
//! [`Constrained`] makes them the identity.

use std::sync::Arc;

use super::grid::{Basis, Grid, Rows, SingleGrid, StiffnessForm, VolumeTerm};
use crate::linalg::{Held, LinearOperator, ResidualUpdate, Workspace};

/// An operator on free unknowns, the identity on held ones.
#[derive(Clone, Debug)]
pub struct Constrained<O> {
    /// Held rows and columns are zero: products have zeros there, and what is
    /// subtracted leaves such entries alone.
    pub free: O,
    /// What is held.
    pub held: Held,
}

impl<O: LinearOperator> LinearOperator for Constrained<O> {
    fn rows(&self) -> usize {
        self.free.rows()
    }

    fn columns(&self) -> usize {
        self.free.columns()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.free.apply(x, y, work);
        self.held.add_held(1.0, x, y);
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.free.apply_transposed(y, x, work);
        self.held.add_held(1.0, y, x);
    }

    fn subtract_product(&self, x: &[f64], r: &mut [f64], work: &mut Workspace) {
        self.free.subtract_product(x, r, work);
        self.held.add_held(-1.0, x, r);
    }
}

/// A of the displacement block.
#[derive(Clone, Debug)]
pub struct Stiffness {
    /// Cells.
    pub grid: Arc<Grid>,
    /// Basis of argument and result.
    pub basis: Basis,
    /// Resistance to changes of volume.
    pub volume: VolumeTerm,
    /// Displacement unknowns.
    pub size: usize,
}

impl LinearOperator for Stiffness {
    fn rows(&self) -> usize {
        self.size
    }

    fn columns(&self) -> usize {
        self.size
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        let form = StiffnessForm {
            basis: self.basis,
            rows: Rows::Free,
            volume: self.volume,
        };
        self.grid.stiffness(form, x, y, work);
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }

    fn subtract_product(&self, x: &[f64], r: &mut [f64], work: &mut Workspace) {
        let on = (self.basis, self.volume);
        self.grid.subtract_stiffness(on, x, r, work);
    }
}

/// What the approximate inverse of the displacement block belongs to, in single precision; the
/// identity on held unknowns.
#[derive(Clone, Debug)]
pub struct SingleStiffness {
    /// Cells.
    pub grid: SingleGrid,
    /// Basis of argument and result.
    pub basis: Basis,
    /// What is held.
    pub held: Held,
}

impl ResidualUpdate<f32> for SingleStiffness {
    fn update_residual(&self, x: &[f32], r: &mut [f32], work: &mut Workspace) {
        self.grid.subtract_stiffness(self.basis, x, r, work);
        self.held.add_held(-1.0, x, r);
    }
}

/// B of the pressure block, hierarchical: (B u)_i = -int lambda_i div u.
#[derive(Clone, Debug)]
pub struct Divergence {
    /// Cells.
    pub grid: Arc<Grid>,
    /// Pressure unknowns.
    pub vertices: usize,
    /// Displacement unknowns.
    pub size: usize,
}

impl LinearOperator for Divergence {
    fn rows(&self) -> usize {
        self.vertices
    }

    fn columns(&self) -> usize {
        self.size
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.grid.divergence(Rows::Free, x, y, work);
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.grid.divergence_transposed(Rows::Free, y, x, work);
    }

    fn add_transposed(&self, factor: f64, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.grid.add_divergence_transposed(factor, y, x, work);
    }
}

/// [A B^T; B 0] of the displacement and pressure blocks, hierarchical.
#[derive(Clone, Debug)]
pub struct Body {
    /// Cells.
    pub grid: Arc<Grid>,
    /// Pressure unknowns.
    pub vertices: usize,
    /// Displacement unknowns.
    pub size: usize,
}

impl LinearOperator for Body {
    fn rows(&self) -> usize {
        self.size + self.vertices
    }

    fn columns(&self) -> usize {
        self.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        let (x, y) = (x.split_at(self.size), y.split_at_mut(self.size));
        self.grid.saddle(x, y, work);
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }
}
