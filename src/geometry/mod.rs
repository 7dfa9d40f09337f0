//! Small vectors and rigid motions in three dimensions.
//!
//! Solves nothing; the ground for meshes and obstacles. Vectors are `[f64; 3]`
//! in two dimensions too, the third component being zero. Every function costs
//! a few flops and allocates nothing.

pub mod rigid_motion;
pub mod symmetric;
pub mod tensor;
pub mod vector3;

pub use rigid_motion::{Matrix3, RigidMotion, rotation_matrix};
