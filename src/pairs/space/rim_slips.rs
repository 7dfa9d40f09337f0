//! What lines beyond rims add to slips and to the change of forces of tractions
//!
//! ```text
//! V_j += w psi_j (y0 - x0) swept,   dW = w p q
//! ```
//!
//! w the weight of the point, p the force there, q its motion ([`super::rims`]). Lengths are those of the
//! caller. Cost: that of a point of [`super::slips`].

use super::choice::Piece;
use super::normals::Vector;
use super::pair::Placed;
use super::patch::{NODES, bernstein};
use super::rims::{RimPoint, VECTORS};
use super::slips::{Before, pull_at};
use crate::geometry::vector3::scale;

/// What a point adds to the change of forces of tractions: factor p q.
pub(super) struct RimPull {
    /// p, the force there by vectors.
    pub(super) force: Vec<(Vector, [f64; 3])>,
    /// q.
    pub(super) motion: [(Vector, [f64; 3]); VECTORS],
    /// Factor.
    pub(super) factor: f64,
}

impl RimPoint {
    /// Weight times what has slid there since `before`, by the functions of the face.
    pub(super) fn slid(&self, both: [usize; 2], before: &Before) -> [[f64; 3]; NODES] {
        let factor = self.site.weight * self.point.area();
        let slid = scale(factor, before.slid(both, &self.point));
        bernstein(self.site.at).map(|value| scale(value, slid))
    }

    /// What it adds to the change of forces of tractions.
    pub(super) fn pull(
        self,
        placed: &Placed<'_>,
        (face, piece): (usize, &Piece),
        tractions: &[[f64; 3]; NODES],
    ) -> RimPull {
        RimPull {
            force: pull_at(&self.point, placed.vectors(face, piece), tractions),
            motion: self.motion,
            factor: self.site.weight,
        }
    }
}
