//! The foamed rubber of Blatz and Ko: W = mu / 2 (I2 / I3 + 2 sqrt(I3) - 5), which is the one term
//! alpha = -2, beta = 1/2 of [`Hyperfoam`], with a Poisson ratio of 1/4 at rest.
//!
//! (Blatz and Ko, Application of finite elastic theory to the deformation of rubbery materials,
//! 1962: their f = 0.) I2 / I3 = l1^-2 + l2^-2 + l3^-2 and sqrt(I3) = J.

use super::hyperfoam::{FoamTerm, Hyperfoam};

/// The law of a shear modulus at rest, stress.
pub fn blatz_ko(shear_modulus: f64) -> Hyperfoam {
    Hyperfoam::new(vec![FoamTerm {
        modulus: shear_modulus,
        exponent: -2.0,
        beta: 0.5,
    }])
}
