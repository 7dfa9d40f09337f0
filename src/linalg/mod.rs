//! Linear algebra on plain slices, and the only door to faer: vector kernels,
//! sparse rows, sparse and dense Cholesky factors, orderings, scratch space.
//!
//! Vectors are `&[f64]`. Every reduction runs over fixed blocks, so that its
//! bits do not depend on the number of threads.

pub mod cholesky;
pub mod dense;
pub mod eigen;
mod factorise_error;
mod gram;
pub mod held;
pub mod indefinite;
pub mod ordering;
#[cfg(test)]
pub(crate) mod samples;
pub mod scalar;
pub mod sparse;
pub mod symmetric;
pub mod vector;
mod widened;
pub mod workspace;

pub use cholesky::SparseCholesky;
pub use dense::{DenseCholesky, DenseLu, DenseMatrix};
pub use factorise_error::FactoriseError;
pub use gram::GramFactor;
pub use held::{Held, HeldNode};
pub use scalar::Scalar;
pub use sparse::{SparseRows, SparseRowsBuilder};
pub use symmetric::{PartFactor, SymmetricMatrix};
pub use widened::Widened;
pub use workspace::Workspace;

/// A linear map that is applied, not stored.
pub trait LinearOperator: Send + Sync {
    /// Length of the result.
    fn rows(&self) -> usize;
    /// Length of the argument.
    fn columns(&self) -> usize;
    /// `y = A x`.
    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace);
    /// `x = A^T y`.
    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace);

    /// `r -= A x`; in one sweep where the operator can.
    fn subtract_product(&self, x: &[f64], r: &mut [f64], work: &mut Workspace) {
        let mut product = work.scratch(r.len());
        self.apply(x, &mut product, work);
        vector::add_scaled(r, -1.0, &product);
        work.give(product);
    }

    /// `x += factor A^T y`; in one sweep where the operator can.
    fn add_transposed(&self, factor: f64, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        let mut product = work.scratch(x.len());
        self.apply_transposed(y, &mut product, work);
        vector::add_scaled(x, factor, &product);
        work.give(product);
    }
}

/// A linear map whose products are taken off a residual, in the numbers R: all that a smoother
/// asks of it.
pub trait ResidualUpdate<R>: Send + Sync {
    /// `r -= A x`.
    fn update_residual(&self, x: &[R], r: &mut [R], work: &mut Workspace);
}

impl ResidualUpdate<f64> for std::sync::Arc<dyn LinearOperator> {
    fn update_residual(&self, x: &[f64], r: &mut [f64], work: &mut Workspace) {
        self.subtract_product(x, r, work);
    }
}

/// An approximate inverse. Scratch is passed in, so that one preconditioner
/// serves many sessions at once.
pub trait Preconditioner: Send + Sync {
    /// `z ~ A^-1 r`.
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace);

    /// The same for `count` vectors, one after the other; at once where that costs less.
    fn apply_to_all(&self, r: &[f64], z: &mut [f64], count: usize, work: &mut Workspace) {
        let length = r.len() / count.max(1);
        let pairs = r
            .chunks_exact(length.max(1))
            .zip(z.chunks_exact_mut(length.max(1)));
        pairs.for_each(|(r, z)| self.apply(r, z, work));
    }
}
