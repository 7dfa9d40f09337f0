//! The saddle point with non-negative multipliers: small dense problems, and
//! the one-level method for the large ones.

pub mod dense_qp;
pub mod one_level;
pub mod qp;

pub use one_level::OneLevel;
pub use qp::{QpIterate, QpNorms, QpOutcome, QpScales, QpStatus, QpTargets};
