//! Solvers of the P1 stiffness A11, one file each.
//!
//! A11 is symmetric positive definite; rows and columns of held components are
//! the identity. Unknowns are numbered vertex by vertex.

mod direct;

pub use direct::{DirectP1, vertex_order};
