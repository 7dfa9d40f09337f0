//! The saddle point with non-negative multipliers: small dense problems, and
//! the one-level method for the large ones.

pub mod dense_qp;
pub mod one_level;

pub use one_level::{OneLevel, QpIterate, QpNorms, QpOutcome, QpScales, QpStatus, QpTargets};
