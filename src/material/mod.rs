//! Constitutive laws: linear bodies, rubber by invariants, by stretches and by
//! any function of the invariants, compressible foams, viscous flow.

mod arruda_boyce;
mod blatz_ko;
mod energy;
mod gent;
mod hyperfoam;
mod invariants;
mod linear_elastic;
mod mixed;
mod ogden;
mod polynomial;
mod potential;
mod principal;
mod rubber;
mod sheet;
pub(crate) mod stability;
mod stokes;
mod van_der_waals;

pub use arruda_boyce::ArrudaBoyce;
pub use blatz_ko::blatz_ko;
pub use energy::Derivatives;
pub use gent::Gent;
pub use hyperfoam::{FoamTerm, Hyperfoam};
pub use invariants::{Deformation, InvariantLaw};
pub use linear_elastic::LinearElastic;
pub use ogden::{Ogden, OgdenTerm};
pub use polynomial::{POWERS, Polynomial};
pub use potential::Potential;
#[cfg(test)]
pub(crate) use potential::examples;
pub use principal::TangentMatrix;
pub use rubber::{Isochoric, Rubber};
pub use sheet::{BodyLaw, Sheet};
pub use stokes::Stokes;
pub use van_der_waals::VanDerWaals;
