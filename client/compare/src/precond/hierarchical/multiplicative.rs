//! Block Gauss-Seidel: z1 = A11^-1 r1, z2 = S22 (r2 - A21 z1). Not symmetric; one
//! operator product and one P1 solve per application.

use super::Splitting;
use signorini::linalg::vector::subtract_from;
use signorini::linalg::{Preconditioner, Workspace};

/// The multiplicative variant.
#[derive(Clone)]
pub(crate) struct Multiplicative(pub(crate) Splitting);

impl Splitting {
    /// z1 = A11^-1 r1, z2 = S22 (r2 - A21 z1).
    pub(super) fn vertices_then_edges(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let (r1, r2) = r.split_at(self.vertex_unknowns);
        self.vertices
            .apply(r1, &mut z[..self.vertex_unknowns], work);
        z[self.vertex_unknowns..].fill(0.0);
        let mut residual = work.scratch(r.len());
        self.operator.apply(z, &mut residual, work);
        let (_, residual2) = residual.split_at_mut(self.vertex_unknowns);
        subtract_from(residual2, r2);
        self.edges
            .apply(residual2, &mut z[self.vertex_unknowns..], work);
        work.give(residual);
    }
}

impl Preconditioner for Multiplicative {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        self.0.vertices_then_edges(r, z, work);
    }
}
