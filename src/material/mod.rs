//! Constitutive laws, one file each.

mod invariants;
mod linear_elastic;
mod rubber;
mod stokes;

pub use invariants::{Deformation, InvariantLaw};
pub use linear_elastic::LinearElastic;
pub use rubber::{Isochoric, Rubber};
pub use stokes::Stokes;
