//! The isochoric law of Ogden in the principal stretches l1, l2, l3 of F,
//! those of volume one being m_k = J^(-1/3) l_k:
//!
//! ```text
//! W = sum_i (mu_i / alpha_i) (m1^alpha_i + m2^alpha_i + m3^alpha_i - 3)
//! ```
//!
//! (Ogden, "Large deformation isotropic elasticity", 1972; Holzapfel, Nonlinear
//! Solid Mechanics, 6.5-6.6.) With C = F^T F = sum_k c_k q_k q_k^T the stress is
//!
//! ```text
//! P = sum_k (tau_k / c_k) F q_k (x) q_k,   tau_k = sum_i mu_i (m_k^alpha_i - mean over k)
//! ```
//!
//! by way of [`super::principal`], which also tells the cost.

use sha2::{Digest, Sha256};

use super::principal::{PrincipalLaw, Stretches, TangentMatrix, second_exponential};
use crate::geometry::tensor::Tensor;

/// One term of the sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OgdenTerm {
    /// Modulus mu_i of the term, stress; its product with the exponent is positive.
    pub modulus: f64,
    /// Exponent alpha_i of the stretches, not zero, without unit.
    pub exponent: f64,
}

/// The law; stable where every product mu_i alpha_i is positive.
#[derive(Clone, Debug, PartialEq)]
pub struct Ogden {
    /// One to three terms, added up.
    pub terms: Vec<OgdenTerm>,
}

impl Ogden {
    /// The law in units of `stress`.
    pub fn over(&self, stress: f64) -> Self {
        let terms = self.terms.iter().map(|term| OgdenTerm {
            modulus: term.modulus / stress,
            exponent: term.exponent,
        });
        Self {
            terms: terms.collect(),
        }
    }

    /// Adds the law to a digest that tells laws apart.
    pub(super) fn hash_into(&self, hash: &mut Sha256) {
        hash.update(b"ogden");
        for term in &self.terms {
            hash.update(term.modulus.to_le_bytes());
            hash.update(term.exponent.to_le_bytes());
        }
    }
}

impl Ogden {
    /// At rest, stress.
    #[must_use]
    pub fn shear_modulus(&self) -> f64 {
        let terms = self.terms.iter();
        terms.map(|term| 0.5 * term.modulus * term.exponent).sum()
    }

    /// W at displacement gradient `h`.
    #[must_use]
    pub fn energy(&self, h: &Tensor<f64>) -> f64 {
        let logarithm = Stretches::new(h).logarithm;
        let of_term = |term: &OgdenTerm| {
            // The logarithms sum up to zero, so that their first order drops out.
            let powers = logarithm.map(|e| second_exponential(term.exponent * e));
            term.modulus / term.exponent * (powers[0] + powers[1] + powers[2])
        };
        self.terms.iter().map(of_term).sum()
    }

    /// dW/dF at displacement gradient `h`.
    #[must_use]
    pub fn stress(&self, h: &Tensor<f64>) -> Tensor<f64> {
        self.stress_at(h)
    }

    /// d2W/dF2 at displacement gradient `h`.
    #[must_use]
    pub fn tangent(&self, h: &Tensor<f64>) -> TangentMatrix {
        self.tangent_at(h)
    }
}

impl PrincipalLaw for Ogden {
    fn stresses(&self, at: &Stretches) -> [f64; 3] {
        let mut stress = [0.0; 3];
        for term in &self.terms {
            let powers = at.logarithm.map(|e| (term.exponent * e).exp_m1());
            let mean = (powers[0] + powers[1] + powers[2]) / 3.0;
            (0..3).for_each(|k| stress[k] += term.modulus * (powers[k] - mean));
        }
        [0, 1, 2].map(|k| stress[k] / at.square[k])
    }

    fn slopes(&self, at: &Stretches, stresses: &[f64; 3]) -> Tensor<f64> {
        let mut slopes = [[0.0; 3]; 3];
        for term in &self.terms {
            let powers = at.logarithm.map(|e| (term.exponent * e).exp());
            let third = (powers[0] + powers[1] + powers[2]) / 3.0;
            for k in 0..3 {
                for l in 0..3 {
                    let own = if k == l { powers[k] } else { 0.0 };
                    let slope = own - (powers[k] + powers[l] - third) / 3.0;
                    slopes[k][l] += 0.5 * term.modulus * term.exponent * slope;
                }
            }
        }
        for k in 0..3 {
            for l in 0..3 {
                slopes[k][l] /= at.square[k] * at.square[l];
            }
            slopes[k][k] -= stresses[k] / at.square[k];
        }
        slopes
    }

    fn shear(&self, at: &Stretches, (k, l): (usize, usize)) -> f64 {
        let slope = |term: &OgdenTerm| {
            let weight = term.modulus * term.exponent;
            at.power_slope((k, l), [weight, term.exponent, at.logarithm[l]])
        };
        self.terms.iter().map(slope).sum()
    }
}

#[cfg(test)]
mod tests;
