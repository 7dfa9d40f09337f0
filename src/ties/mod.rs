//! Surfaces of two bodies that are bonded to each other, whose meshes need not match:
//!
//! ```text
//! int psi_j (u_2(x) - u_1(x)) dS = 0   for each component,   x on the first surface
//! ```
//!
//! The first surface, the carrier, has the functions psi_j; u_2(x) is the displacement of the other
//! body at the same point, that of its cell behind the facet, continued where the facets leave a gap
//! or overlap. Both sides are compared at one place, so that fields linear in x meet the equations
//! whatever the meshes: rigid motions of any size cost nothing, and the forces of a tie have no sum
//! and no moment. Integrals are over the exact intersections of the facets, projected along the
//! normals of the carrier's: segments in the plane, clipped triangles in space. Undeformed; about an
//! axis over the full turn. All rows are linear in the displacement and are found once.
//!
//! | file | part |
//! |---|---|
//! | [`cell`] | a point in a cell, or beside it, and the displacement there |
//! | [`overlap`] | which parts of a facet have which partners |
//! | [`seam`] | rows of all functions, what they cover, and how wide the gap is |
//! | [`functions`] | which functions have multipliers |
//! | [`tied`] | one component of a tie: gaps and coupling |
//!
//! References: C. Bernardi, Y. Maday and A. Patera, *A new nonconforming approach to domain
//! decomposition: the mortar element method* (1994); M. Puso, *A 3D mortar method for solid
//! mechanics* (2004).

pub mod cell;
pub mod functions;
pub mod overlap;
pub mod seam;
pub mod tied;

pub use functions::{Lost, layout_of};
pub use seam::{Seam, Sides};
pub use tied::{TieForce, Tied};

#[cfg(test)]
mod tests;
