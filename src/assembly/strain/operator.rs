//! The tangent as linear operators on eliminated systems: rows and columns of
//! held unknowns are zero in A and B, as [`Constrained`] takes them.
//!
//! [`Constrained`]: crate::assembly::Constrained

use std::sync::Arc;

use super::cells::{Linearised, StrainGrid};
use super::tangent::StiffnessTerm;
use crate::assembly::grid::{Basis, Rows};
use crate::linalg::{LinearOperator, Workspace};

/// A state and the cells it belongs to.
#[derive(Clone, Debug)]
pub struct TangentStiffness {
    /// Cells.
    pub cells: Arc<StrainGrid>,
    /// The state.
    pub at: Arc<Linearised>,
    /// Basis of argument and result.
    pub basis: Basis,
    /// Adds this times the shear modulus times int dJ cof F.
    pub volumetric: f64,
    /// Displacement unknowns.
    pub size: usize,
}

impl TangentStiffness {
    fn add(&self, factor: f64, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        let term = StiffnessTerm {
            basis: self.basis,
            volumetric: self.volumetric,
            factor,
        };
        self.cells.about(&self.at).add_stiffness(term, x, y, work);
    }
}

impl LinearOperator for TangentStiffness {
    fn rows(&self) -> usize {
        self.size
    }

    fn columns(&self) -> usize {
        self.size
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        y.fill(0.0);
        self.add(1.0, x, y, work);
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }

    fn subtract_product(&self, x: &[f64], r: &mut [f64], work: &mut Workspace) {
        self.add(-1.0, x, r, work);
    }
}

/// B, hierarchical.
#[derive(Clone, Debug)]
pub struct TangentDivergence {
    /// Cells.
    pub cells: Arc<StrainGrid>,
    /// The state.
    pub at: Arc<Linearised>,
    /// Pressure unknowns.
    pub vertices: usize,
    /// Displacement unknowns.
    pub size: usize,
}

impl LinearOperator for TangentDivergence {
    fn rows(&self) -> usize {
        self.vertices
    }

    fn columns(&self) -> usize {
        self.size
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.cells.about(&self.at).divergence(x, y, work);
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        x.fill(0.0);
        self.add_transposed(1.0, y, x, work);
    }

    fn add_transposed(&self, factor: f64, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        let tangent = self.cells.about(&self.at);
        tangent.add_divergence_transposed(factor, y, x, work);
    }
}

/// [A B^T; B 0], hierarchical.
#[derive(Clone, Debug)]
pub struct TangentBody {
    /// Cells.
    pub cells: Arc<StrainGrid>,
    /// The state.
    pub at: Arc<Linearised>,
    /// Pressure unknowns.
    pub vertices: usize,
    /// Displacement unknowns.
    pub size: usize,
}

impl LinearOperator for TangentBody {
    fn rows(&self) -> usize {
        self.size + self.vertices
    }

    fn columns(&self) -> usize {
        self.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        let (x, y) = (x.split_at(self.size), y.split_at_mut(self.size));
        self.cells.about(&self.at).apply(Rows::Free, x, y, work);
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }
}
