//! The softest motion of an equilibrium of rubber and its eigenvalue,
//!
//! ```text
//! K x = l P x,   B x = 0,   C_A x = 0
//! ```
//!
//! as [`super::certificate`] finds it. Shape `[displacement unknowns]`.

use crate::report::Stability;

/// The softest motion of the last equilibrium.
#[derive(Clone, Debug)]
pub(crate) struct LowestMode {
    /// x, of unit length in P `[displacement unknowns]`.
    pub(crate) motion: Vec<f64>,
    /// The eigenvalue l of the softest motion, in units of the stiffness at rest;
    /// negative at a saddle.
    pub(crate) eigenvalue: f64,
}

impl LowestMode {
    /// What the sign says.
    pub(crate) fn stability(&self) -> Stability {
        match self.eigenvalue > 0.0 {
            true => Stability::Minimum,
            false => Stability::Saddle,
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        8 * self.motion.len() as u64
    }
}
