//! Eigenvalues and directions of a symmetric tensor of three by three numbers:
//!
//! ```text
//! A = Q diag(d) Q^T,   Q^T Q = I
//! ```
//!
//! by cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, 8.5),
//! which find tiny eigenvalue differences and equal eigenvalues alike: errors are
//! some units in the last place of the largest entry. Cost about 400 flops.

use super::tensor::Tensor;

/// Sweeps after which every finite tensor is diagonal to the last bit.
const SWEEPS: usize = 12;

/// Eigenvalues in no order; column k of `directions` belongs to value k.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum {
    /// Eigenvalues d_k `[3]`, in no order.
    pub values: [f64; 3],
    /// Orthonormal directions as the columns of Q, one for each value.
    pub directions: Tensor<f64>,
}

impl Spectrum {
    /// Of a symmetric tensor; a tensor that is not finite gives one that is not.
    #[must_use]
    pub fn new(symmetric: &Tensor<f64>) -> Self {
        let mut a = *symmetric;
        let mut directions = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for _ in 0..SWEEPS {
            if a[0][1] == 0.0 && a[0][2] == 0.0 && a[1][2] == 0.0 {
                break;
            }
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                rotate(&mut a, &mut directions, p, q);
            }
        }
        Self {
            values: [a[0][0], a[1][1], a[2][2]],
            directions,
        }
    }

    /// Direction `k`.
    #[must_use]
    pub fn direction(&self, k: usize) -> [f64; 3] {
        [0, 1, 2].map(|i| self.directions[i][k])
    }
}

/// Makes entry (p, q) of `a` zero.
fn rotate(a: &mut Tensor<f64>, directions: &mut Tensor<f64>, p: usize, q: usize) {
    let off = a[p][q];
    let sum = a[p][p].abs() + a[q][q].abs();
    // What does not change the last bit of the diagonal is gone.
    if off.abs() <= 0.25 * f64::EPSILON * sum {
        (a[p][q], a[q][p]) = (0.0, 0.0);
        return;
    }
    let ratio = 0.5 * (a[q][q] - a[p][p]) / off;
    let tangent = ratio.signum() / (ratio.abs() + ratio.hypot(1.0));
    let cosine = tangent.hypot(1.0).recip();
    let sine = tangent * cosine;
    a[p][p] -= tangent * off;
    a[q][q] += tangent * off;
    (a[p][q], a[q][p]) = (0.0, 0.0);
    let r = 3 - p - q;
    let (left, right) = (a[r][p], a[r][q]);
    a[r][p] = cosine * left - sine * right;
    a[r][q] = sine * left + cosine * right;
    (a[p][r], a[q][r]) = (a[r][p], a[r][q]);
    for row in directions {
        (row[p], row[q]) = (
            cosine * row[p] - sine * row[q],
            sine * row[p] + cosine * row[q],
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tensor::{product, transposed};

    fn rebuilt(spectrum: &Spectrum) -> Tensor<f64> {
        let mut scaled = spectrum.directions;
        for row in &mut scaled {
            (0..3).for_each(|k| row[k] *= spectrum.values[k]);
        }
        product(&scaled, &transposed(&spectrum.directions))
    }

    fn distance(a: &Tensor<f64>, b: &Tensor<f64>) -> f64 {
        let pairs = a.as_flattened().iter().zip(b.as_flattened());
        pairs.fold(0.0, |most: f64, (x, y)| most.max((x - y).abs()))
    }

    const UNIT: Tensor<f64> = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn values_and_directions_rebuild_the_tensor() {
        let general = [[2.0, -0.3, 0.7], [-0.3, -1.0, 0.2], [0.7, 0.2, 0.5]];
        let nearly_equal = [[1.0, 1e-9, 0.0], [1e-9, 1.0, 1e-12], [0.0, 1e-12, 1.0]];
        let equal_off_diagonals = [[0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]];
        let huge = general.map(|row| row.map(|x| 1e150 * x));
        let tiny = general.map(|row| row.map(|x| 1e-150 * x));
        for (tensor, size) in [
            (general, 1.0),
            (nearly_equal, 1.0),
            (equal_off_diagonals, 1.0),
            (huge, 1e150),
            (tiny, 1e-150),
        ] {
            let spectrum = Spectrum::new(&tensor);
            assert!(distance(&rebuilt(&spectrum), &tensor) < 4e-15 * size);
            let q = &spectrum.directions;
            assert!(distance(&product(&transposed(q), q), &UNIT) < 4e-15);
        }
    }

    #[test]
    fn known_values_are_found() {
        let tensor = [[0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]];
        let mut values = Spectrum::new(&tensor).values;
        values.sort_by(f64::total_cmp);
        for (found, exact) in values.iter().zip([-1.0, -1.0, 2.0]) {
            assert!((found - exact).abs() < 2e-15);
        }
    }

    #[test]
    fn a_tensor_that_is_not_finite_ends_without_values() {
        let spectrum = Spectrum::new(&[[f64::NAN; 3]; 3]);
        assert!(spectrum.values.iter().any(|value| value.is_nan()));
    }
}
