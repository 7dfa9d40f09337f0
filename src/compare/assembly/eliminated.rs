//! Assembled matrices as operators on eliminated systems: rows and columns of held
//! unknowns are the identity in the stiffness and zero in the divergence.
//!
//! The matrices stay whole, since reactions need all rows; arguments are zero at
//! held unknowns, so that only rows are left to mend. Cost: one product.

use std::sync::Arc;

use crate::linalg::{LinearOperator, SparseRows, SparseRowsBuilder, Workspace};

/// A with rows and columns of held unknowns the identity, on vectors that are
/// zero there but for what is to be kept.
#[derive(Clone, Debug)]
pub(crate) struct Eliminated {
    /// A with nothing eliminated `[unknowns, unknowns]`; held rows and columns are
    /// skipped in the product.
    pub(crate) matrix: Arc<SparseRows>,
    /// Indices of the held unknowns, ascending.
    pub(crate) held: Arc<[u32]>,
}

impl LinearOperator for Eliminated {
    fn rows(&self) -> usize {
        self.matrix.rows()
    }

    fn columns(&self) -> usize {
        self.matrix.columns()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.matrix.apply(x, y, work);
        for &index in self.held.iter() {
            y[index as usize] = x[index as usize];
        }
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }
}

/// B with its transpose, whose held rows are zero.
#[derive(Clone, Debug)]
pub(crate) struct EliminatedCoupling {
    /// B with nothing eliminated `[pressures, unknowns]`.
    pub(crate) matrix: SparseRows,
    /// B transposed `[unknowns, pressures]`, stored so that both products run along
    /// rows.
    pub(crate) transposed: SparseRows,
    /// Indices of the held displacement unknowns, ascending; their columns of B count
    /// as zero.
    held: Arc<[u32]>,
}

impl EliminatedCoupling {
    /// Of B; held indices ascending.
    pub(crate) fn new(matrix: SparseRows, held: Arc<[u32]>) -> Self {
        Self {
            transposed: transpose(&matrix),
            matrix,
            held,
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        self.matrix.bytes() + self.transposed.bytes()
    }
}

/// The transposed matrix, its rows in ascending order of columns. Cost: one pass over
/// the entries.
fn transpose(matrix: &SparseRows) -> SparseRows {
    let mut rows: Vec<Vec<(u32, f64)>> = vec![Vec::new(); matrix.columns()];
    for row in 0..matrix.rows() {
        let (columns, values) = matrix.row(row);
        for (&column, &value) in columns.iter().zip(values) {
            rows[column as usize].push((row as u32, value));
        }
    }
    let mut builder = SparseRowsBuilder::new(matrix.rows());
    rows.iter_mut().for_each(|row| builder.push_row(row));
    builder.finish()
}

impl LinearOperator for EliminatedCoupling {
    fn rows(&self) -> usize {
        self.matrix.rows()
    }

    fn columns(&self) -> usize {
        self.matrix.columns()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.matrix.apply(x, y, work);
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.transposed.apply(y, x, work);
        for &index in self.held.iter() {
            x[index as usize] = 0.0;
        }
    }
}
