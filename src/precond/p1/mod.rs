//! Solvers of the P1 stiffness A11, one file each.
//!
//! A11 is symmetric positive definite; rows and columns of held components are
//! the identity. Unknowns are numbered vertex by vertex.

pub mod amg;
mod direct;
mod incomplete;

pub use amg::{AmgError, AmgP1, VertexBlocks};
pub use direct::{DirectP1, vertex_order};
pub use incomplete::{IncompleteCholeskyCg, incomplete_cholesky_cg};

/// Displacements of surface vertices along one direction each.
#[derive(Clone, Copy, Debug)]
pub struct Traces<'a> {
    /// Vertices.
    pub vertices: &'a [u32],
    /// Unit vectors, zero in held components `[vertices]`.
    pub directions: &'a [[f64; 3]],
}
