//! Krylov methods that conjugate gradients and GCR are compared with, behind the
//! same monitor and outcome.

pub(crate) mod minres;
pub(crate) mod stationary;
