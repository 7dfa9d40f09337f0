//! What surfaces lie on, non-dimensional places aside. Cost: none.

use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// What surfaces lie on.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Numbering of the displacement.
    pub space: &'a TaylorHood,
    /// Whether supports hold a displacement unknown.
    pub is_held: &'a dyn Fn(u32) -> bool,
}
