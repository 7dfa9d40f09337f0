//! Why a Cholesky factorisation, sparse or dense, has no result.

/// Why a factorisation failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FactoriseError {
    /// A pivot is zero, negative or not a number.
    #[error("the matrix is not positive definite")]
    NotPositiveDefinite,
    /// The factor does not fit into memory or its indices overflow.
    #[error("the factor does not fit into memory")]
    OutOfMemory,
}
