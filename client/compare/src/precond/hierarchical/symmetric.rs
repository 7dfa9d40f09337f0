//! Block SSOR, the seed's "121": vertices, edges, vertices again. Symmetric
//! positive definite; two operator products and two P1 solves per application.

use super::Splitting;
use signorini::linalg::vector::{add_scaled, subtract_from};
use signorini::linalg::{Preconditioner, Workspace};

/// The symmetric variant.
#[derive(Clone)]
pub(crate) struct Symmetric(pub(crate) Splitting);

impl Preconditioner for Symmetric {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let vertices = self.0.vertex_unknowns;
        self.0.vertices_then_edges(r, z, work);
        let mut residual = work.scratch(r.len());
        let mut correction = work.scratch(vertices);
        self.0.operator.apply(z, &mut residual, work);
        subtract_from(&mut residual[..vertices], &r[..vertices]);
        self.0
            .vertices
            .apply(&residual[..vertices], &mut correction, work);
        add_scaled(&mut z[..vertices], 1.0, &correction);
        work.give(residual);
        work.give(correction);
    }
}
