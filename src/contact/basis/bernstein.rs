//! The quadratic Bernstein polynomials: L_v^2 of a vertex, 2 L_a L_b of an edge.
//!
//! They span the P2 trace of the displacement, so that contact pressures far above
//! the shear modulus stay stable, and contain the hats as a cone: Lam_v = lambda_v,
//! Lam_e = (lambda_a + lambda_b) / 2. Non-negative coefficients give a non-negative
//! pressure everywhere. int psi_k dS is the same for all functions of a face.
//! Monomials integrate by int L^n dS = d! n! / (|n| + d)! |T| in d dimensions.

use std::f64::consts::TAU;

use super::ContactBasis;
use crate::contact::face::ContactFace;
use crate::geometry::Matrix3;
use crate::geometry::rigid_motion::multiply;
use crate::geometry::tensor::cofactor;
use crate::geometry::vector3::{add, dot, scale};

/// One function a vertex and one an edge.
#[derive(Clone, Copy, Debug)]
pub struct Bernstein;

/// psi_k = factor L_a L_b as (factor, a, b).
fn factors(corners: usize, k: usize) -> (f64, usize, usize) {
    let edge = match (corners, k.checked_sub(corners)) {
        (_, None) => return (1.0, k, k),
        (_, Some(0)) => (0, 1),
        (_, Some(1)) => (0, 2),
        (_, Some(_)) => (1, 2),
    };
    (2.0, edge.0, edge.1)
}

/// int L_a L_b .. over a simplex of measure one; `factors` lists the corners.
fn mean(corners: usize, factors: &[usize]) -> f64 {
    let factorial = |n: usize| (1..=n).product::<usize>() as f64;
    let powers = (0..corners).map(|c| factorial(factors.iter().filter(|&&f| f == c).count()));
    let dimension = corners - 1;
    factorial(dimension) * powers.product::<f64>() / factorial(factors.len() + dimension)
}

/// F in lambda = l . F l; zero beyond the corners.
fn quadratic_form(corners: usize, coefficients: &[f64]) -> Matrix3 {
    let mut form = [[0.0; 3]; 3];
    for (k, &coefficient) in coefficients.iter().enumerate() {
        let (_, a, b) = factors(corners, k);
        form[a][b] = coefficient;
        form[b][a] = coefficient;
    }
    form
}

/// Corners of a face, and the points of its edges and of its inside where l . F l is stationary.
fn stationary(corners: usize, form: &Matrix3) -> Vec<[f64; 3]> {
    let unit = |own: usize| -> [f64; 3] { std::array::from_fn(|i| f64::from(u8::from(i == own))) };
    let mut points: Vec<[f64; 3]> = (0..corners).map(unit).collect();
    for a in 0..corners {
        for b in a + 1..corners {
            let [at_a, at_b] = [form[b][b] - form[a][b], form[a][a] - form[a][b]];
            let shares = [at_a, at_b].map(|share| share / (at_a + at_b));
            points.push(add(scale(shares[0], unit(a)), scale(shares[1], unit(b))));
        }
    }
    // F l = mu (1, 1, 1): l is in proportion to the sums of the cofactors' rows.
    let sums = cofactor(form).map(|row| row.iter().sum::<f64>());
    points.push(scale(sums.iter().sum::<f64>().recip(), sums));
    points.retain(|l| l.iter().all(|share| (0.0..=1.0).contains(share)));
    points
}

impl ContactBasis for Bernstein {
    fn functions(&self, corners: usize) -> usize {
        corners * (corners + 1) / 2
    }

    fn values(&self, l: &[f64], out: &mut [f64]) {
        for (k, value) in out.iter_mut().enumerate() {
            let (factor, a, b) = factors(l.len(), k);
            *value = factor * l[a] * l[b];
        }
    }

    /// Half the coefficient of an edge and a quarter of those of its ends.
    fn at_nodes(&self, corners: usize, coefficients: &[f64]) -> Vec<f64> {
        let mut values = coefficients.to_vec();
        for (k, value) in values.iter_mut().enumerate().skip(corners) {
            let (_, a, b) = factors(corners, k);
            *value = 0.5 * *value + 0.25 * (coefficients[a] + coefficients[b]);
        }
        values
    }

    /// Of corners, of the stationary points on edges, and of that inside.
    fn largest(&self, corners: usize, coefficients: &[f64]) -> (f64, [f64; 3]) {
        let form = quadratic_form(corners, coefficients);
        let value = |l: &[f64; 3]| dot(*l, multiply(&form, *l));
        let mut known = (0.0, [1.0, 0.0, 0.0]);
        for l in stationary(corners, &form) {
            let value = value(&l);
            if value > known.0 {
                known = (value, l);
            }
        }
        known
    }

    fn weight(&self, face: &ContactFace, k: usize) -> f64 {
        let corners = face.corners.len();
        let (factor, a, b) = factors(corners, k);
        match face.radii {
            None => face.area * factor * mean(corners, &[a, b]),
            Some(radii) => {
                let turned = |end: usize| radii[end] * mean(corners, &[a, b, end]);
                TAU * face.flat_area * factor * (turned(0) + turned(1))
            }
        }
    }

    fn mass(&self, face: &ContactFace, i: usize, j: usize) -> f64 {
        let corners = face.corners.len();
        let ((m, a, b), (n, c, d)) = (factors(corners, i), factors(corners, j));
        face.area * m * n * mean(corners, &[a, b, c, d])
    }

    /// grad psi = factor (L_a grad L_b + L_b grad L_a).
    fn laplacian(
        &self,
        corners: usize,
        hats: &dyn Fn(usize, usize) -> f64,
        [i, j]: [usize; 2],
    ) -> f64 {
        let ((m, a, b), (n, c, d)) = (factors(corners, i), factors(corners, j));
        let mut sum = 0.0;
        for (value, slope) in [(a, b), (b, a)] {
            for (other_value, other_slope) in [(c, d), (d, c)] {
                sum += mean(corners, &[value, other_value]) * hats(slope, other_slope);
            }
        }
        m * n * sum
    }
}
