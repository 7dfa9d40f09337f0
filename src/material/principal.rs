//! Laws in the principal stretches l1, l2, l3 of F: with C = F^T F = sum_k c_k q_k q_k^T and the
//! principal Kirchhoff stresses tau_k,
//!
//! ```text
//! P = sum_k s_k F q_k (x) q_k,   s_k = tau_k / c_k,   tau_k = dW / d ln l_k
//! ```
//!
//! and the tangent is a sum of six symmetric products of such directions (Ogden, Non-linear
//! Elastic Deformations, 6.1; Holzapfel, Nonlinear Solid Mechanics, 6.6). Everything comes from
//! H = F - I through the eigenvalues d of C - I = H + H^T + H^T H: ln l = ln_1p(d) / 2, l^alpha - 1
//! by expm1, and the slopes between two directions as (tau_k - tau_l) / (c_k - c_l), which
//! [`Stretches::power_slope`] gives of each power for equal and nearly equal stretches as well.
//! J > 0 is assumed: the stretches do not see a mirror image.
//!
//! Cost at a point: some 600 flops and a dozen transcendental functions for the stress of two
//! powers, twice that with the tangent.

use crate::geometry::symmetric::Spectrum;
use crate::geometry::tensor::{Tensor, plus_unit, product, transposed};

/// Derivatives of an energy, row and column 3 i + j for entry (i, j) of F.
pub type TangentMatrix = [[f64; 9]; 9];

/// Stretches and their directions at a deformation.
pub(super) struct Stretches {
    /// d_k = l_k^2 - 1, the eigenvalues of 2 E, exact for small strains.
    excess: [f64; 3],
    /// c_k = l_k^2, the squares of the principal stretches.
    pub(super) square: [f64; 3],
    /// ln l_k.
    pub(super) whole: [f64; 3],
    /// ln m_k of the stretches without the change of volume, m_k = J^(-1/3) l_k; their sum is zero.
    pub(super) logarithm: [f64; 3],
    /// q_k, orthonormal principal directions in the undeformed body.
    directions: [[f64; 3]; 3],
    /// F q_k, the principal directions as the deformation carries them.
    pushed: [[f64; 3]; 3],
}

impl Stretches {
    /// Stretches of I + H by the eigenvalues of H + H^T + H^T H, which keeps the digits
    /// of small strains.
    pub(super) fn new(h: &Tensor<f64>) -> Self {
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
            whole,
            logarithm: whole.map(|e| e - mean),
            directions,
            pushed: directions.map(|q| f.map(|row| row[0] * q[0] + row[1] * q[1] + row[2] * q[2])),
        }
    }

    /// ln J.
    pub(super) fn volume(&self) -> f64 {
        self.whole[0] + self.whole[1] + self.whole[2]
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

    /// Of x_k = `weight` / alpha exp(alpha e_k) with the logarithms e, all of which differ from ln l
    /// by one number: c_l (x_k - x_l) / (c_k - c_l), and its limit.
    pub(super) fn power_slope(
        &self,
        (k, l): (usize, usize),
        [weight, exponent, e]: [f64; 3],
    ) -> f64 {
        let relative = (self.excess[k] - self.excess[l]) / self.square[l];
        let half = 0.5 * mean_logarithm(relative);
        let power = (exponent * e).exp();
        let grown = mean_exponential(exponent * half * relative);
        weight * power * grown * half
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
pub(super) fn second_exponential(x: f64) -> f64 {
    if x.abs() > 0.5 {
        return x.exp_m1() - x;
    }
    // x^2/2 (1 + x/3 (1 + x/4 (1 + ..))): the last term is below 1e-18.
    let tail = (3..=16)
        .rev()
        .fold(1.0, |sum, n| 1.0 + sum * x / f64::from(n));
    0.5 * x * x * tail
}

/// What a law in the principal stretches must tell.
pub(super) trait PrincipalLaw {
    /// s_k = tau_k / c_k.
    fn stresses(&self, at: &Stretches) -> [f64; 3];

    /// ds_k / dc_l, symmetric; `stresses` are s_k.
    fn slopes(&self, at: &Stretches, stresses: &[f64; 3]) -> Tensor<f64>;

    /// c_l (tau_k - tau_l) / (c_k - c_l) of the directions k and l, and its limit.
    fn shear(&self, at: &Stretches, pair: (usize, usize)) -> f64;

    /// dW/dF at displacement gradient `h`.
    fn stress_at(&self, h: &Tensor<f64>) -> Tensor<f64> {
        let at = Stretches::new(h);
        product(&plus_unit(h), &at.coaxial(&self.stresses(&at)))
    }

    /// d2W/dF2 at displacement gradient `h`.
    fn tangent_at(&self, h: &Tensor<f64>) -> TangentMatrix {
        let at = Stretches::new(h);
        let stresses = self.stresses(&at);
        let mut tangent = initial_stress(&at.coaxial(&stresses));
        let slopes = self.slopes(&at, &stresses);
        let dyads = [0, 1, 2].map(|k| at.dyad(k, k));
        for (k, row) in slopes.iter().enumerate() {
            let mixed: [f64; 9] =
                std::array::from_fn(|n| (0..3).map(|l| 2.0 * row[l] * dyads[l][n]).sum());
            add_product(&mut tangent, 1.0, &dyads[k], &mixed);
        }
        for (k, l) in [(0, 1), (0, 2), (1, 2)] {
            let (one, other) = (at.dyad(k, l), at.dyad(l, k));
            let pair: [f64; 9] = std::array::from_fn(|n| one[n] + other[n]);
            // (s_k - s_l) / (c_k - c_l).
            let slope = (self.shear(&at, (k, l)) / at.square[l] - stresses[l]) / at.square[k];
            add_product(&mut tangent, slope, &pair, &pair);
        }
        tangent
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
