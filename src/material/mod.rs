//! Constitutive laws: linear bodies, rubber by invariants, by stretches and by
//! any function of the invariants, viscous flow.

mod arruda_boyce;
mod energy;
mod gent;
mod invariants;
mod linear_elastic;
mod ogden;
mod polynomial;
mod potential;
mod rubber;
pub(crate) mod stability;
mod stokes;

pub use arruda_boyce::ArrudaBoyce;
pub use energy::Derivatives;
pub use gent::Gent;
pub use invariants::{Deformation, InvariantLaw};
pub use linear_elastic::LinearElastic;
pub use ogden::{Ogden, OgdenTerm, TangentMatrix};
pub use polynomial::{POWERS, Polynomial};
pub use potential::Potential;
#[cfg(test)]
pub(crate) use potential::examples;
pub use rubber::{Isochoric, Rubber};
pub use stokes::Stokes;
