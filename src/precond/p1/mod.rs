//! Solvers of the P1 stiffness A11, one file each.
//!
//! A11 is symmetric positive definite; rows and columns of held components are
//! the identity. Unknowns are numbered vertex by vertex.

pub mod amg;
mod direct;

pub use amg::{AmgError, AmgP1, VertexBlocks};
pub use direct::{DirectP1, vertex_order};

/// Displacements of surface vertices along the directions that their multipliers have.
#[derive(Clone, Copy, Debug)]
pub struct Traces<'a> {
    /// Vertex of each trace, ascending; as often as it has directions `[traces]`.
    pub vertices: &'a [u32],
    /// Unit vectors, zero in held components `[traces]`.
    pub directions: &'a [[f64; 3]],
}
