//! Sparse Cholesky factor of A11, contact vertices eliminated last.
//!
//! With L_cc the trailing block of the factor on the contact unknowns,
//! (A11^-1)_cc = L_cc^-T L_cc^-1: one factorisation gives both the solver and
//! the compliance of the contact surface.

use super::Traces;
use crate::linalg::cholesky::{LowerColumns, Precision};
use crate::linalg::ordering::{Graph, nested_dissection};
use crate::linalg::{DenseMatrix, FactoriseError, Preconditioner, SparseCholesky, Workspace};

/// A factor of A11.
#[derive(Debug)]
pub struct DirectP1 {
    /// The sparse Cholesky factor, held components eliminated.
    factor: SparseCholesky,
}

/// Elimination order of the vertices (new to old): nested dissection, with
/// `last` after all others.
pub fn vertex_order(coordinates: &[[f64; 3]], edges: &[[u32; 2]], last: &[u32]) -> Vec<u32> {
    let graph = Graph::from_edges(coordinates.len(), edges);
    nested_dissection(coordinates, &graph, last)
}

impl DirectP1 {
    /// Factorises `matrix` `[vertices * components]` in the given vertex order.
    ///
    /// # Errors
    /// When the matrix is not positive definite or the factor does not fit.
    pub fn new(
        matrix: &LowerColumns,
        vertex_order: &[u32],
        components: usize,
        precision: Precision,
    ) -> Result<Self, FactoriseError> {
        let order: Vec<u32> = vertex_order
            .iter()
            .flat_map(|&vertex| (0..components as u32).map(move |c| vertex * components as u32 + c))
            .collect();
        Ok(Self {
            factor: SparseCholesky::new(matrix, &order, precision)?,
        })
    }

    /// A11^-1 on `traces`, whose vertices must be the last in elimination order.
    pub fn compliance(&self, traces: &Traces<'_>, components: usize) -> DenseMatrix {
        let mut vertices = traces.vertices.to_vec();
        vertices.dedup();
        let size = vertices.len() * components;
        let mut directions = DenseMatrix::zeros(size, traces.vertices.len());
        let pairs = traces.vertices.iter().zip(traces.directions);
        for (column, (vertex, direction)) in pairs.enumerate() {
            let place = vertices.partition_point(|other| other < vertex);
            for i in 0..components {
                *directions.at_mut(place * components + i, column) = direction[i];
            }
        }
        let last = self.factor.trailing_block(size);
        // With friction most vertices have all directions, and the columns are a staircase.
        if 3 * vertices.len() < 2 * traces.vertices.len() {
            last.inverse_of_product_below(directions)
        } else {
            last.inverse_of_product_on(directions)
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        self.factor.bytes()
    }
}

impl Preconditioner for DirectP1 {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        z.copy_from_slice(r);
        self.factor.solve(z, 1, work);
    }

    fn apply_to_all(&self, r: &[f64], z: &mut [f64], count: usize, work: &mut Workspace) {
        z.copy_from_slice(r);
        self.factor.solve(z, count, work);
    }
}
