//! Why preparation fails.

use crate::linalg::FactoriseError;
use crate::report::Termination;

/// Why preparation failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PrepareError {
    /// The caller cancelled or its time is up.
    #[error("stopped while preparing: {}", .0.name())]
    Stopped(Termination),
    /// A11 cannot be factorised.
    #[error("the P1 stiffness cannot be factorised: {0}")]
    Factorise(#[from] FactoriseError),
}
