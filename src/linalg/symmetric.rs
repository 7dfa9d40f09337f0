//! Symmetric matrices that are known by their products and principal parts: dense ones,
//! and sums of low rank and sparse parts that are never formed as a whole.

use std::sync::Arc;

use super::{DenseCholesky, DenseMatrix, FactoriseError, Workspace};

/// The inverse of a principal part.
pub trait PartFactor: Send + Sync {
    /// Solves in place `[rows of the part]`.
    fn solve_part(&self, right_hand_side: &mut [f64], work: &mut Workspace);

    /// Bytes held.
    fn bytes(&self) -> u64;
}

impl PartFactor for DenseCholesky {
    fn solve_part(&self, right_hand_side: &mut [f64], _work: &mut Workspace) {
        self.solve(right_hand_side);
    }

    fn bytes(&self) -> u64 {
        8 * (self.size() as u64).pow(2)
    }
}

/// A symmetric matrix `[size, size]`.
pub trait SymmetricMatrix: Send + Sync {
    /// Number of rows and columns.
    fn size(&self) -> usize;

    /// One entry.
    fn entry(&self, row: usize, column: usize) -> f64;

    /// All diagonal entries.
    fn diagonal(&self) -> Vec<f64> {
        (0..self.size()).map(|i| self.entry(i, i)).collect()
    }

    /// `y = A x`.
    fn product(&self, x: &[f64], y: &mut [f64]);

    /// Rows and columns `selected`, ascending, as a dense matrix.
    fn principal_part(&self, selected: &[usize]) -> DenseMatrix;

    /// The same for a caller who asks for many parts that have most of their rows in common: a
    /// matrix may keep what it has made.
    fn part_again(&self, selected: &[usize]) -> DenseMatrix {
        self.principal_part(selected)
    }

    /// Factor of that part. A matrix may keep the last one: methods ask for the same part
    /// several times.
    ///
    /// # Errors
    /// When the part is not positive definite.
    fn factor_of_part(&self, selected: &[usize]) -> Result<Arc<dyn PartFactor>, FactoriseError> {
        Ok(Arc::new(DenseCholesky::new(
            &self.principal_part(selected),
        )?))
    }

    /// All of it.
    fn dense(&self) -> DenseMatrix {
        let all: Vec<usize> = (0..self.size()).collect();
        self.principal_part(&all)
    }
}

impl SymmetricMatrix for DenseMatrix {
    fn size(&self) -> usize {
        self.rows()
    }

    fn entry(&self, row: usize, column: usize) -> f64 {
        self.at(row, column)
    }

    fn product(&self, x: &[f64], y: &mut [f64]) {
        self.multiply(x, y);
    }

    fn principal_part(&self, selected: &[usize]) -> DenseMatrix {
        self.principal(selected)
    }
}
