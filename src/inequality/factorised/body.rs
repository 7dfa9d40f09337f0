//! The body alone by a factor of its saddle point, for many loads:
//!
//! ```text
//! [ A  B^T    ] [u]   [f]
//! [ B  -S - e ] [p] = [g]
//! ```
//!
//! scaled, shifted and ordered as with constraints; the shift leaves an error of about
//! 1e-9 in pressures. Cost: one factor; a solution reads it twice.

use super::super::qp::QpStatus;
use super::system::{Matrices, System};
use crate::linalg::Workspace;
use crate::linalg::indefinite::SparseIndefinite;

/// A factor of the body without contact.
#[derive(Debug)]
pub struct BodyFactor {
    /// D `[displacement, pressures]`.
    scale: Vec<f64>,
    factor: SparseIndefinite,
}

impl BodyFactor {
    /// Of stored matrices without multipliers of contact.
    ///
    /// # Errors
    /// [`QpStatus::TooLarge`] where the factor takes more than it may,
    /// [`QpStatus::IndefiniteMetric`] for a singular matrix.
    pub fn new(matrices: &Matrices<'_>) -> Result<Self, QpStatus> {
        let system = System::new(matrices)?;
        Ok(Self {
            factor: system.factor(&[])?,
            scale: system.scale,
        })
    }

    /// Unknowns `[displacement, pressures]`.
    pub fn size(&self) -> usize {
        self.scale.len()
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        8 * self.scale.len() as u64 + self.factor.bytes()
    }

    /// Solves in place for loads one after the other `[count, size]`.
    pub fn solve(&self, loads: &mut [f64], work: &mut Workspace) {
        self.rescale(loads);
        self.factor.solve(loads, work);
        self.rescale(loads);
    }

    fn rescale(&self, loads: &mut [f64]) {
        for load in loads.chunks_exact_mut(self.scale.len()) {
            load.iter_mut().zip(&self.scale).for_each(|(x, d)| *x *= d);
        }
    }
}
