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
//! and the tangent is a sum of six symmetric products of such directions. Everything
//! comes from H = F - I through the eigenvalues d of C - I = H + H^T + H^T H:
//! ln l = ln_1p(d) / 2, m^alpha - 1 by expm1, and the slopes between two directions
//! as (tau_k - tau_l) / (c_k - c_l) = sum mu m_l^alpha expm1(alpha x) / (c_k - c_l)
//! with x = ln(l_k / l_l), which is exact for equal and nearly equal stretches.
//! J > 0 is assumed: the stretches do not see a mirror image.
//!
//! Cost at a point: some 600 flops and a dozen transcendental functions for the
//! stress, twice that with the tangent.

use sha2::{Digest, Sha256};

use crate::geometry::symmetric::Spectrum;
use crate::geometry::tensor::{Tensor, plus_unit, product, transposed};

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

/// Derivatives of an energy, row and column 3 i + j for entry (i, j) of F.
pub type TangentMatrix = [[f64; 9]; 9];

/// Stretches and their directions at a deformation.
struct Stretches {
    /// d_k = l_k^2 - 1, the eigenvalues of 2 E, exact for small strains.
    excess: [f64; 3],
    /// c_k = l_k^2, the squares of the principal stretches.
    square: [f64; 3],
    /// ln m_k of the stretches without the change of volume; their sum is zero.
    logarithm: [f64; 3],
    /// q_k, orthonormal principal directions in the undeformed body.
    directions: [[f64; 3]; 3],
    /// F q_k, the principal directions as the deformation carries them.
    pushed: [[f64; 3]; 3],
}

impl Stretches {
    /// Stretches of I + H by the eigenvalues of H + H^T + H^T H, which keeps the digits
    /// of small strains.
    fn new(h: &Tensor<f64>) -> Self {
        let turned = transposed(h);
        let mut strain = product(&turned, h);
        for i in 0..3 {
            for j in 0..3 {
                strain[i][j] += h[i][j] + turned[i][j];
            }
        }
        let spectrum = Spectrum::new(&strain);
        let excess = spectrum.values;
        let whole = excess.map(|d| 0.5 * d.ln_1p());
        let mean = (whole[0] + whole[1] + whole[2]) / 3.0;
        let f = plus_unit(h);
        let directions = [0, 1, 2].map(|k| spectrum.direction(k));
        Self {
            excess,
            square: excess.map(|d| 1.0 + d),
            logarithm: whole.map(|e| e - mean),
            directions,
            pushed: directions.map(|q| f.map(|row| row[0] * q[0] + row[1] * q[1] + row[2] * q[2])),
        }
    }

    /// F q_k (x) q_l.
    fn dyad(&self, k: usize, l: usize) -> [f64; 9] {
        std::array::from_fn(|n| self.pushed[k][n / 3] * self.directions[l][n % 3])
    }

    /// sum_k weights_k q_k (x) q_k.
    fn coaxial(&self, weights: &[f64; 3]) -> Tensor<f64> {
        let mut sum = [[0.0; 3]; 3];
        for (weight, q) in weights.iter().zip(&self.directions) {
            for (row, left) in sum.iter_mut().zip(q) {
                (0..3).for_each(|j| row[j] += weight * left * q[j]);
            }
        }
        sum
    }
}

/// (exp(x) - 1) / x.
fn mean_exponential(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.exp_m1() / x }
}

/// ln(1 + x) / x.
fn mean_logarithm(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.ln_1p() / x }
}

/// exp(x) - 1 - x.
fn second_exponential(x: f64) -> f64 {
    if x.abs() > 0.5 {
        return x.exp_m1() - x;
    }
    // x^2/2 (1 + x/3 (1 + x/4 (1 + ..))): the last term is below 1e-18.
    let tail = (3..=16)
        .rev()
        .fold(1.0, |sum, n| 1.0 + sum * x / f64::from(n));
    0.5 * x * x * tail
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

    /// tau_k / c_k.
    fn principal_stresses(&self, at: &Stretches) -> [f64; 3] {
        let mut stress = [0.0; 3];
        for term in &self.terms {
            let powers = at.logarithm.map(|e| (term.exponent * e).exp_m1());
            let mean = (powers[0] + powers[1] + powers[2]) / 3.0;
            (0..3).for_each(|k| stress[k] += term.modulus * (powers[k] - mean));
        }
        [0, 1, 2].map(|k| stress[k] / at.square[k])
    }

    /// dW/dF at displacement gradient `h`.
    #[must_use]
    pub fn stress(&self, h: &Tensor<f64>) -> Tensor<f64> {
        let at = Stretches::new(h);
        product(&plus_unit(h), &at.coaxial(&self.principal_stresses(&at)))
    }

    /// d2W/dF2 at displacement gradient `h`.
    #[must_use]
    pub fn tangent(&self, h: &Tensor<f64>) -> TangentMatrix {
        let at = Stretches::new(h);
        let stresses = self.principal_stresses(&at);
        let mut tangent = initial_stress(&at.coaxial(&stresses));
        let slopes = self.principal_slopes(&at, &stresses);
        let dyads = [0, 1, 2].map(|k| at.dyad(k, k));
        for (k, row) in slopes.iter().enumerate() {
            let mixed: [f64; 9] =
                std::array::from_fn(|n| (0..3).map(|l| 2.0 * row[l] * dyads[l][n]).sum());
            add_product(&mut tangent, 1.0, &dyads[k], &mixed);
        }
        for (k, l) in [(0, 1), (0, 2), (1, 2)] {
            let (one, other) = (at.dyad(k, l), at.dyad(l, k));
            let pair: [f64; 9] = std::array::from_fn(|n| one[n] + other[n]);
            let slope = self.shear_slope(&at, &stresses, k, l);
            add_product(&mut tangent, slope, &pair, &pair);
        }
        tangent
    }

    /// d(tau_k / c_k) / dc_l, symmetric.
    fn principal_slopes(&self, at: &Stretches, stresses: &[f64; 3]) -> Tensor<f64> {
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

    /// (tau_k / c_k - tau_l / c_l) / (c_k - c_l), and its limit.
    fn shear_slope(&self, at: &Stretches, stresses: &[f64; 3], k: usize, l: usize) -> f64 {
        let relative = (at.excess[k] - at.excess[l]) / at.square[l];
        let half = 0.5 * mean_logarithm(relative);
        let slope = |term: &OgdenTerm| {
            let power = (term.exponent * at.logarithm[l]).exp();
            let grown = mean_exponential(term.exponent * half * relative);
            term.modulus * term.exponent * power * grown * half
        };
        let sum: f64 = self.terms.iter().map(slope).sum();
        (sum / at.square[l] - stresses[l]) / at.square[k]
    }
}

/// dF S : dF of a second Piola-Kirchhoff stress S.
fn initial_stress(stress: &Tensor<f64>) -> TangentMatrix {
    let mut tangent = [[0.0; 9]; 9];
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                tangent[3 * i + j][3 * i + k] = stress[j][k];
            }
        }
    }
    tangent
}

/// Adds `factor` times the outer product of two flattened tensors to the tangent `[9,
/// 9]`.
fn add_product(tangent: &mut TangentMatrix, factor: f64, left: &[f64; 9], right: &[f64; 9]) {
    for (row, a) in tangent.iter_mut().zip(left) {
        for (entry, b) in row.iter_mut().zip(right) {
            *entry += factor * a * b;
        }
    }
}

#[cfg(test)]
mod tests;
