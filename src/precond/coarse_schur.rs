//! The metric of the internal pressure in a thin body: beside the mass, which knows nothing of
//! shape, the pressures along the body that hardly change a volume,
//!
//! ```text
//! M^-1 + sum_k e_k z_k z_k^T,   e_k = max(0, 1 / W_k - 1 / (z_k.M z_k))
//! ```
//!
//! z_k orthogonal in the Schur complement, W_k = z_k.(B Y B^T + S) z_k ([`super::volume_mode`]).
//! In a layer bonded on both sides W_k over its mass falls like the square of thickness over
//! wave length, and the iterations with the mass alone grow like length over thickness.
//! Additive, as in two-level Schwarz methods (A. Toselli and O. Widlund, Domain
//! Decomposition Methods, 2005, section 2). Shapes `[pressures]`. Cost: two passes over each z_k.

use super::schur::ChebyshevMass;
use super::volume_mode::VolumeMode;
use crate::linalg::vector::{add_scaled, dot};
use crate::linalg::{LinearOperator, Preconditioner, Workspace};

/// M^-1 with the pressures that it overestimates.
pub struct CoarseSchur<'a> {
    /// M^-1.
    fine: &'a ChebyshevMass,
    /// z and e of each.
    modes: Vec<(Vec<f64>, f64)>,
}

impl<'a> CoarseSchur<'a> {
    /// `fine` with those of `volumes` that change less than it says.
    pub fn new(fine: &'a ChebyshevMass, volumes: &[VolumeMode], work: &mut Workspace) -> Self {
        let mut modes = Vec::new();
        for VolumeMode {
            pressures,
            work: own,
            ..
        } in volumes
        {
            let mut weighed = work.zeros(pressures.len());
            fine.mass().apply(pressures, &mut weighed, work);
            let excess = own.recip() - dot(pressures, &weighed).recip();
            work.give(weighed);
            if excess > 0.0 && excess.is_finite() {
                modes.push((pressures.clone(), excess));
            }
        }
        Self { fine, modes }
    }
}

impl Preconditioner for CoarseSchur<'_> {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        self.fine.apply(r, z, work);
        for (pattern, excess) in &self.modes {
            add_scaled(z, excess * dot(pattern, r), pattern);
        }
    }
}
