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
use super::turned::Turned;
use crate::linalg::Workspace;
use crate::linalg::indefinite::SparseIndefinite;

/// A factor of the body without contact.
#[derive(Debug)]
pub struct BodyFactor {
    /// D `[displacement, pressures]`.
    scale: Vec<f64>,
    factor: SparseIndefinite,
    /// Motions that lower the energy, turned; none where none does or they stay.
    turned: Option<Turned>,
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
            turned: None,
        })
    }

    /// The same of a body that may have motions which lower its energy: on the factor they raise
    /// it by as much.
    ///
    /// # Errors
    /// As those of [`Self::new`]; also [`QpStatus::IndefiniteMetric`] where they are more than
    /// `most`, or not found.
    pub fn stable(
        matrices: &Matrices<'_>,
        most: usize,
        work: &mut Workspace,
    ) -> Result<Self, QpStatus> {
        let system = System::new(matrices)?;
        let factor = system.factor(&[])?;
        let unstable = system.unstable(&factor);
        let turned = match unstable {
            0 => None,
            count if count > most => return Err(QpStatus::IndefiniteMetric),
            count => {
                let sizes = [system.displacements, system.scale.len()];
                let turned = Turned::new(&factor, sizes, count, work);
                Some(turned.ok_or(QpStatus::IndefiniteMetric)?)
            }
        };
        Ok(Self {
            factor,
            scale: system.scale,
            turned,
        })
    }

    /// Whether it is that of the body: no motion of it lowers the energy.
    pub fn is_exact(&self) -> bool {
        self.turned.is_none()
    }

    /// Unknowns `[displacement, pressures]`.
    pub fn size(&self) -> usize {
        self.scale.len()
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        let turned = self.turned.as_ref().map_or(0, Turned::bytes);
        8 * self.scale.len() as u64 + self.factor.bytes() + turned
    }

    /// Solves in place for loads one after the other `[count, size]`.
    pub fn solve(&self, loads: &mut [f64], work: &mut Workspace) {
        self.rescale(loads);
        self.factor.solve(loads, work);
        if let Some(turned) = &self.turned {
            let solutions = loads.chunks_exact_mut(self.scale.len());
            solutions.for_each(|solution| turned.correct(solution));
        }
        self.rescale(loads);
    }

    fn rescale(&self, loads: &mut [f64]) {
        for load in loads.chunks_exact_mut(self.scale.len()) {
            load.iter_mut().zip(&self.scale).for_each(|(x, d)| *x *= d);
        }
    }
}
