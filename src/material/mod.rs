//! Constitutive laws: linear bodies, rubber by invariants, rubber by stretches, viscous flow.

mod invariants;
mod linear_elastic;
mod ogden;
mod rubber;
mod stokes;

pub use invariants::{Deformation, InvariantLaw};
pub use linear_elastic::LinearElastic;
pub use ogden::{Ogden, OgdenTerm, TangentMatrix};
pub use rubber::{Isochoric, Rubber};
pub use stokes::Stokes;
