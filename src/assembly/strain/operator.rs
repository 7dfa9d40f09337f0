//! The tangent as linear operators on eliminated systems: rows and columns of
//! held unknowns are zero in A and B, as [`Constrained`] takes them.
//!
//! [`Constrained`]: crate::assembly::Constrained

use super::products::TangentProducts;
use crate::assembly::grid::Basis;
use crate::linalg::{LinearOperator, Workspace};

/// A and the state it belongs to.
#[derive(Clone, Debug)]
pub struct TangentStiffness {
    /// Products about the state.
    pub products: TangentProducts,
    /// Basis of argument and result.
    pub basis: Basis,
    /// Displacement unknowns.
    pub size: usize,
}

impl TangentStiffness {
    fn add(&self, factor: f64, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        let on = (self.basis, factor);
        self.products.add_stiffness(on, x, y, work);
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
    /// Products about the state.
    pub products: TangentProducts,
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
        self.products.divergence(x, y, work);
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        x.fill(0.0);
        self.add_transposed(1.0, y, x, work);
    }

    fn add_transposed(&self, factor: f64, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.products.add_divergence_transposed(factor, y, x, work);
    }
}

/// [A B^T; B 0], hierarchical.
#[derive(Clone, Debug)]
pub struct TangentBody {
    /// Products about the state.
    pub products: TangentProducts,
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
        self.products.apply(x, y, work);
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }
}
