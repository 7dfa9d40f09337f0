//! Krylov methods over [`crate::linalg::LinearOperator`] and
//! [`crate::linalg::Preconditioner`]: conjugate gradients for symmetric
//! positive definite systems, truncated flexible GCR for saddle points, the Lanczos process
//! for the sign of the least eigenvalue.
//!
//! A [`Monitor`] sees every residual and decides when to stop; no method
//! prints, and every loop has a typed outcome.

pub mod cg;
pub mod gcr;
pub mod least_eigenvalue;
#[cfg(test)]
pub(crate) mod samples;
pub mod sweeps;

/// What the monitor says after an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Go on.
    Continue,
    /// Accurate enough, or somebody asked to stop.
    Stop,
}

/// Watches a Krylov method.
pub trait Monitor {
    /// Called after each iteration with the current residual.
    fn judge(&mut self, residual: &[f64]) -> Verdict;

    /// Called after each iteration of a method nested in this one.
    fn poll(&mut self) -> Verdict {
        Verdict::Continue
    }
}

/// How a Krylov method ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The monitor stopped it.
    Stopped,
    /// It used up its iterations.
    IterationLimit,
    /// It no longer reduces the residual.
    Stagnation,
    /// A number became infinite or undefined.
    NotFinite,
    /// The operator, or for MINRES the preconditioner, is not positive definite.
    Indefinite,
}
