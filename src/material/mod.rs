//! Constitutive laws, one file each.

mod linear_elastic;

pub use linear_elastic::LinearElastic;
