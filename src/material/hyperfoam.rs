//! Compressible foams by Ogden's law of principal stretches with a volume of its own (Hill):
//!
//! ```text
//! W = sum_i 2 mu_i / alpha_i^2 [ l1^alpha_i + l2^alpha_i + l3^alpha_i - 3 + (J^(-alpha_i beta_i) - 1) / beta_i ]
//! tau_k = dW / d ln l_k = sum_i 2 mu_i / alpha_i (l_k^alpha_i - J^(-alpha_i beta_i))
//! ```
//!
//! (Hill, Aspects of invariance in solid mechanics, 1978; Storakers, On material representation and
//! constitutive branching in finite compressible elasticity, 1986.) beta_i = nu_i / (1 - 2 nu_i);
//! where it is zero the last term is -alpha_i ln J. At rest mu = sum mu_i and
//! K = sum 2 mu_i (1/3 + beta_i).
//!
//! The mixed form has a pressure p with its -p (J - 1) - p^2 / 2k beside each law. So that the two
//! together are W at each point where p = -k (J - 1), displacements carry
//!
//! ```text
//! W - k/2 (J - 1)^2
//! ```
//!
//! The bulk modulus k of the pressure cancels but for what P1 misses of J - 1, of the order of the
//! error of the elements. It is small, because what P1 misses takes k from the stiffness of the
//! volume: that falls as J^(-alpha beta) in tension, and where it is below k a mesh has motions that
//! the foam has not. Near a Poisson ratio of 1/2 displacements carry the whole volume, and meshes
//! are as stiff as those of the displacement form.

use sha2::{Digest, Sha256};

use super::linear_elastic::CARRIED_BY_PRESSURE;
use super::principal::{PrincipalLaw, Stretches, TangentMatrix, second_exponential};
use crate::geometry::tensor::Tensor;

/// One term of the sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoamTerm {
    /// Modulus mu_i of the term, stress.
    pub modulus: f64,
    /// Exponent alpha_i of the stretches, not zero, without unit.
    pub exponent: f64,
    /// beta_i of the volume, above -1/3, without unit.
    pub beta: f64,
}

/// The law; stable wherever each modulus is above zero and each beta at least zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Hyperfoam {
    /// One to six terms, added up.
    terms: Vec<FoamTerm>,
    /// k, stress.
    carried: f64,
}

impl Hyperfoam {
    /// The law of these terms, its k chosen by its moduli at rest.
    pub fn new(terms: Vec<FoamTerm>) -> Self {
        let mut law = Self {
            terms,
            carried: 0.0,
        };
        let (shear, bulk) = (law.shear_modulus(), law.bulk_modulus());
        law.carried = (CARRIED_BY_PRESSURE * shear).min(0.5 * bulk);
        law
    }

    /// The terms.
    pub fn terms(&self) -> &[FoamTerm] {
        &self.terms
    }

    /// k, stress: the bulk modulus that the pressure carries.
    pub fn carried(&self) -> f64 {
        self.carried
    }

    /// At rest, stress.
    pub fn shear_modulus(&self) -> f64 {
        self.terms.iter().map(|term| term.modulus).sum()
    }

    /// At rest, stress.
    pub fn bulk_modulus(&self) -> f64 {
        let of_term = |term: &FoamTerm| 2.0 * term.modulus * (1.0 / 3.0 + term.beta);
        self.terms.iter().map(of_term).sum()
    }

    /// At rest.
    pub fn poisson_ratio(&self) -> f64 {
        let (shear, bulk) = (self.shear_modulus(), self.bulk_modulus());
        (3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear)
    }

    /// The law in units of `stress`.
    pub fn over(&self, stress: f64) -> Self {
        let terms = self.terms.iter().map(|term| FoamTerm {
            modulus: term.modulus / stress,
            ..*term
        });
        Self {
            terms: terms.collect(),
            carried: self.carried / stress,
        }
    }

    /// Adds the law to a digest that tells laws apart.
    pub(super) fn hash_into(&self, hash: &mut Sha256) {
        hash.update(b"hyperfoam");
        for term in &self.terms {
            for number in [term.modulus, term.exponent, term.beta] {
                hash.update(number.to_le_bytes());
            }
        }
    }

    /// tau_k of the whole law at the logarithms of the stretches.
    pub(super) fn kirchhoff(&self, logarithms: &[f64; 3]) -> [f64; 3] {
        let volume = logarithms[0] + logarithms[1] + logarithms[2];
        let mut stress = [0.0; 3];
        for term in &self.terms {
            let weight = 2.0 * term.modulus / term.exponent;
            let held = (-term.exponent * term.beta * volume).exp_m1();
            for (sum, e) in stress.iter_mut().zip(logarithms) {
                *sum += weight * ((term.exponent * e).exp_m1() - held);
            }
        }
        stress
    }

    /// dtau_k / d ln l_m of the whole law: what the diagonal has, and what all entries have beside.
    pub(super) fn kirchhoff_slopes(&self, logarithms: &[f64; 3]) -> ([f64; 3], f64) {
        let volume = logarithms[0] + logarithms[1] + logarithms[2];
        let (mut own, mut all) = ([0.0; 3], 0.0);
        for term in &self.terms {
            let twice = 2.0 * term.modulus;
            for (sum, e) in own.iter_mut().zip(logarithms) {
                *sum += twice * (term.exponent * e).exp();
            }
            all += twice * term.beta * (-term.exponent * term.beta * volume).exp();
        }
        (own, all)
    }

    /// W - k/2 (J - 1)^2 at displacement gradient `h`.
    pub fn energy(&self, h: &Tensor<f64>) -> f64 {
        let logarithms = Stretches::new(h).whole;
        let volume = logarithms[0] + logarithms[1] + logarithms[2];
        let of_term = |term: &FoamTerm| {
            // The first orders of the stretches and of the volume cancel.
            let powers = logarithms.map(|e| second_exponential(term.exponent * e));
            let held = if term.beta == 0.0 {
                0.0
            } else {
                second_exponential(-term.exponent * term.beta * volume) / term.beta
            };
            let sum = powers[0] + powers[1] + powers[2] + held;
            2.0 * term.modulus / (term.exponent * term.exponent) * sum
        };
        let whole: f64 = self.terms.iter().map(of_term).sum();
        whole - 0.5 * self.carried * volume.exp_m1().powi(2)
    }

    /// Its derivative by F at displacement gradient `h`.
    pub fn stress(&self, h: &Tensor<f64>) -> Tensor<f64> {
        self.stress_at(h)
    }

    /// Its second derivative by F at displacement gradient `h`.
    pub fn tangent(&self, h: &Tensor<f64>) -> TangentMatrix {
        self.tangent_at(h)
    }
}

impl PrincipalLaw for Hyperfoam {
    fn stresses(&self, at: &Stretches) -> [f64; 3] {
        let whole = self.kirchhoff(&at.whole);
        let change = at.volume().exp_m1();
        let carried = self.carried * change * (1.0 + change);
        [0, 1, 2].map(|k| (whole[k] - carried) / at.square[k])
    }

    fn slopes(&self, at: &Stretches, stresses: &[f64; 3]) -> Tensor<f64> {
        let (own, all) = self.kirchhoff_slopes(&at.whole);
        let jacobian = at.volume().exp();
        // d/d ln J of k (J - 1) J.
        let all = all - self.carried * jacobian * (2.0 * jacobian - 1.0);
        let mut slopes = [[0.0; 3]; 3];
        for k in 0..3 {
            for l in 0..3 {
                let sum = if k == l { own[k] + all } else { all };
                slopes[k][l] = 0.5 * sum / (at.square[k] * at.square[l]);
            }
            slopes[k][k] -= stresses[k] / at.square[k];
        }
        slopes
    }

    fn shear(&self, at: &Stretches, (k, l): (usize, usize)) -> f64 {
        let slope = |term: &FoamTerm| {
            let weight = 2.0 * term.modulus;
            at.power_slope((k, l), [weight, term.exponent, at.whole[l]])
        };
        self.terms.iter().map(slope).sum()
    }
}

#[cfg(test)]
mod tests;
