//! Constitutive laws, one file each.

mod linear_elastic;
mod stokes;

pub use linear_elastic::LinearElastic;
pub use stokes::Stokes;
