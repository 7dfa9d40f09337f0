//! Rubber in mixed form: an isochoric energy W(F) and a volumetric part,
//!
//! ```text
//! W(F) - p (J - 1) - p^2 / 2K,   so that P = dW/dF - p cof F,  -(J - 1) - p / K = 0
//! ```
//!
//! with bulk modulus K, 1/K = 0 where the volume cannot change.

use super::InvariantLaw;

/// The isochoric part.
#[derive(Clone, Debug, PartialEq)]
pub enum Isochoric {
    /// Mooney-Rivlin, neo-Hookean, Yeoh.
    Invariants(InvariantLaw<f64>),
}

/// A rubber.
#[derive(Clone, Debug, PartialEq)]
pub struct Rubber {
    /// W.
    pub isochoric: Isochoric,
    /// 1 / K, one over stress; zero where the volume cannot change.
    pub inverse_bulk: f64,
}

impl Rubber {
    /// Shear modulus at rest, stress.
    pub fn shear_modulus(&self) -> f64 {
        match &self.isochoric {
            Isochoric::Invariants(law) => law.modulus(),
        }
    }
}
