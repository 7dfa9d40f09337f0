//! The volume term that the approximate inverse of a mixed body holds beside A,
//!
//! ```text
//! A^ ~ (A + gamma mu int div u div v)^-1
//! ```
//!
//! The saddle point is solved augmented by gamma B^T M^-1 B to match: its Schur complement is nearer
//! to the mass than that of A, and in the block-triangular step only the share of the pressure
//! step that moves the displacement grows (decision 50). The tangent of rubber resists no change
//! of volume, so that there the term makes A^ that of linear elasticity (decision 19).

use super::Plan;
use crate::precond::p_multigrid::Smoothing;
use crate::scene::{DisplacementMethod, SaddleMethod};

/// gamma of rubber, in units of the shear modulus.
pub(crate) const VOLUMETRIC: f64 = 2.0 / 3.0;
/// gamma of linear bodies.
const LINEAR: f64 = 0.5;
/// Contrast of shear moduli from which on A itself serves better.
const MOST_CONTRAST: f64 = 10.0;

impl Plan {
    /// The volume term of a linear body's approximate inverse beside that of A, in units of the
    /// shear modulus.
    pub(crate) fn augmentation(&self) -> f64 {
        if self.is_augmented() { LINEAR } else { 0.0 }
    }

    /// Whether the approximate inverse of a linear body holds such a term.
    pub(crate) fn is_augmented(&self) -> bool {
        self.may_be_augmented() && self.solves_augmented()
    }

    /// Whether the body is one that is solved faster so.
    fn may_be_augmented(&self) -> bool {
        self.is_mixed()
            && !self.problem.resolved.is_rubber()
            && self.decisions.displacement == DisplacementMethod::PMultigrid
            && self.penalty() == 0.0
            && self.problem.contrast() <= MOST_CONTRAST
    }

    /// Methods that do not solve augmented take the inverse of A itself.
    fn solves_augmented(&self) -> bool {
        self.decisions.saddle.method == SaddleMethod::Gcr
            && !self.decisions.contact.method.has_fixed_steps()
    }

    /// What tells prepared data for other methods from those for the usual one, whose keys are
    /// as old as the first release.
    pub(super) fn key_of_inverse(&self) -> &'static [u8] {
        if self.may_be_augmented() && !self.solves_augmented() {
            b"not augmented"
        } else {
            b""
        }
    }

    /// The smoothing of p-multigrid: after the P1 correction alone, by one product less, where
    /// what is around it does not ask for symmetry.
    pub(crate) fn smoothing(&self) -> Smoothing {
        let degree = self.decisions.smoother_degree;
        if self.is_augmented() && !self.smooths_along_lines() {
            Smoothing::After(2 * degree - 1)
        } else {
            Smoothing::Around(degree)
        }
    }

    /// Inverse of the pressure's metric beside the mass over mu. Of gamma, half of which makes it
    /// longer serves contact and tractions alike.
    pub(crate) fn pressure_step(&self) -> f64 {
        self.decisions.displacement.pressure_step() + 0.5 * self.augmentation() + self.penalty()
    }

    /// Share of the pressure step that moves the displacement, where A^ holds a volume term of
    /// this weight beside A.
    pub(crate) fn augmented_share(&self, weight: f64) -> f64 {
        1.0 + weight / self.pressure_step()
    }
}
