//! The saddle point with multipliers in admissible sets: small dense problems, and
//! the methods for the large ones behind one trait, one file each.
//!
//! | file | method | products with the compliance | sets |
//! |---|---|---|---|
//! | [`one_level`] | all unknowns together, set by the dense problem | none | all |
//! | [`factorised`] | a factor of the whole on each set | none | bounds |
//! | [`mprgp`] | proportioning with reduced gradient projection | one to two | bounds |
//!
//! Bounds are products of lines and half lines: contact and bilateral supports.

pub mod augmentation;
pub mod blocks;
pub mod condensed;
pub mod dense_cone;
pub mod factorised;
pub mod linear;
pub mod metric;
pub mod mprgp;
pub mod one_level;
pub mod qp;

pub use augmentation::Augmentation;
pub use factorised::{BodyFactor, FactorStep, Inertia, Matrices, inertia};
pub use linear::{LinearSolver, LinearSystem};
pub use one_level::OneLevel;
pub(crate) use one_level::augmented::Augmented;
pub(crate) use one_level::slides_of;
pub use qp::{
    BlockIterate, QpIterate, QpNorms, QpOutcome, QpProblem, QpRun, QpScales, QpStatus, QpTargets,
    Slide,
};

/// A method for the quadratic program of [`one_level`].
pub trait InequalitySolver {
    /// Improves `iterate` until the targets of `run` are reached; keeps the
    /// best iterate where they are not.
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome;
}

#[cfg(test)]
mod samples;
