//! The grid's passes as linear operators on eliminated systems: rows and
//! columns of held unknowns are the identity in the stiffness and zero in the
//! divergence.

use std::sync::Arc;

use super::grid::{Basis, Grid, Rows};
use crate::linalg::{LinearOperator, Workspace};

/// A of the displacement block.
#[derive(Clone, Debug)]
pub struct Stiffness {
    /// Cells.
    pub grid: Arc<Grid>,
    /// Basis of argument and result.
    pub basis: Basis,
    /// Displacement unknowns.
    pub size: usize,
    /// Ascending indices of held entries.
    pub held: Arc<[u32]>,
}

impl LinearOperator for Stiffness {
    fn rows(&self) -> usize {
        self.size
    }

    fn columns(&self) -> usize {
        self.size
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.grid.stiffness(self.basis, Rows::Free, x, y, work);
        for &index in self.held.iter() {
            y[index as usize] = x[index as usize];
        }
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }

    fn subtract_product(&self, x: &[f64], r: &mut [f64], work: &mut Workspace) {
        self.grid.subtract_stiffness(self.basis, x, r, work);
        for &index in self.held.iter() {
            r[index as usize] -= x[index as usize];
        }
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
    /// Ascending indices of held entries.
    pub held: Arc<[u32]>,
}

impl LinearOperator for Body {
    fn rows(&self) -> usize {
        self.size + self.vertices
    }

    fn columns(&self) -> usize {
        self.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        let (force, volume) = y.split_at_mut(self.size);
        self.grid
            .saddle(x.split_at(self.size), (force, volume), work);
        for &index in self.held.iter() {
            y[index as usize] = x[index as usize];
        }
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }
}
