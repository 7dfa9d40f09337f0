//! Gent's law of limited chain extensibility: W = -mu J_m / 2 ln(1 - (i1 - 3) / J_m) (Gent, A new
//! constitutive relation for rubber, 1996).
//!
//! From [`LAST`] of the limit on the slope goes on along its tangent, so that steps of the solver
//! which lead too far still have an energy that calls them back: dW/di1 is 500 mu there.

use super::energy::{Derivatives, Energy};

/// Share of J_m, without unit, from which on the slope is linear: dW/di1 is 500 mu there; chosen, no
/// scene measures it.
const LAST: f64 = 0.999;

/// The law.
#[derive(Clone, Debug, PartialEq)]
pub struct Gent {
    /// mu at rest, stress, above zero.
    pub shear_modulus: f64,
    /// J_m, the limit of i1 - 3, above zero.
    pub limit: f64,
}

impl Energy for Gent {
    fn at(&self, first: f64, _second: f64) -> Derivatives {
        let (half, limit) = (0.5 * self.shear_modulus, self.limit);
        let inside = first.min(LAST * limit);
        let beyond = first - inside;
        let left = limit / (limit - inside);
        let (slope, bend) = (half * left, half * left * left / limit);
        Derivatives {
            value: -half * limit * (-inside / limit).ln_1p()
                + beyond * (slope + 0.5 * bend * beyond),
            first: slope + bend * beyond,
            first_first: bend,
            ..Default::default()
        }
    }

    fn over(&self, stress: f64) -> Self {
        Self {
            shear_modulus: self.shear_modulus / stress,
            limit: self.limit,
        }
    }

    fn numbers(&self) -> (&'static str, Vec<f64>) {
        ("gent", vec![self.shear_modulus, self.limit])
    }
}
