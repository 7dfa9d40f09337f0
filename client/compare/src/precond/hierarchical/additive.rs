//! Block diagonal: z1 = A11^-1 r1, z2 = S22 r2. Symmetric positive definite; no
//! operator product and one P1 solve per application.

use super::Splitting;
use signorini::linalg::{Preconditioner, Workspace};

/// The additive variant.
#[derive(Clone)]
pub(crate) struct Additive(pub(crate) Splitting);

impl Preconditioner for Additive {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let (r1, r2) = r.split_at(self.0.vertex_unknowns);
        let (z1, z2) = z.split_at_mut(self.0.vertex_unknowns);
        self.0.vertices.apply(r1, z1, work);
        self.0.edges.apply(r2, z2, work);
    }
}
