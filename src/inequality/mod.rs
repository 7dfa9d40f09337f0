//! The saddle point with non-negative multipliers: small dense problems, and
//! the methods for the large ones behind one trait, one file each.
//!
//! | file | method | products with the compliance |
//! |---|---|---|
//! | [`one_level`] | all unknowns together, set by the dense problem | none |
//! | [`active_set`] | primal-dual active set, each set solved to the end | none |
//! | [`nested`] | projected steps in a metric that learns | one a step |
//! | [`mprgp`] | proportioning with reduced gradient projection | one to two |
//! | [`projected_gradient`] | conjugate projected gradient | one to two |
//! | [`arrow_hurwicz`] | fixed projected steps in the metric | one a step |

pub mod active_set;
pub mod arrow_hurwicz;
mod condensed;
pub mod dense_qp;
pub mod method;
pub mod metric;
pub mod mprgp;
pub mod nested;
pub mod one_level;
pub mod projected_gradient;
pub mod qp;

pub use method::{ContactMethod, MetricKind, choose};
pub use one_level::OneLevel;
pub use qp::{QpIterate, QpNorms, QpOutcome, QpProblem, QpRun, QpScales, QpStatus, QpTargets};

/// A method for the quadratic program of [`one_level`].
pub trait InequalitySolver {
    /// Improves `iterate` until the targets of `run` are reached; keeps the
    /// best iterate where they are not.
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome;
}

#[cfg(test)]
mod samples;
#[cfg(test)]
mod tests;
