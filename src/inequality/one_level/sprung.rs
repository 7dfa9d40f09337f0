//! The step of a displacement preconditioner that knows the constraints as springs,
//! A^ ~ (A + C^T W C)^-1: by the identity
//!
//! ```text
//! A u + C^T l = f,  C u = g      (A + C^T W C) u + C^T l' = f + E^T g,  C u = g,  l = l' + E u
//! ```
//!
//! with E = W C / 2 it is a step of the system as it stands, whose residuals remain those
//! that are reported. Cost: two products with C on the face a step.

use super::GAP_WEIGHT;
use crate::linalg::{LinearOperator, Preconditioner, Workspace};
use crate::saddle::Status;

/// Half of W for constraints and multipliers in the weights of a face, zero off the face.
pub(super) fn on_the_face(springs: &[f64], moduli: &[f64], status: &[Status]) -> Vec<f64> {
    let weight = |index: usize| GAP_WEIGHT * moduli.get(index).unwrap_or(&1.0);
    let half = |(index, (spring, &status)): (usize, (&f64, &Status))| match status {
        Status::Stick => 0.5 * spring / weight(index).powi(2),
        Status::Open | Status::Slip => 0.0,
    };
    springs.iter().zip(status).enumerate().map(half).collect()
}

/// The step on a face.
pub(super) struct Sprung<'a> {
    /// The step by A^, of displacement, equalities and contact.
    pub(super) inner: &'a dyn Preconditioner,
    /// C on the face, weighted.
    pub(super) constraints: &'a dyn LinearOperator,
    /// Half of W in its weights `[multipliers]`.
    pub(super) springs: &'a [f64],
}

impl Sprung<'_> {
    fn pull(&self, values: &mut [f64]) {
        let springs = values.iter_mut().zip(self.springs);
        springs.for_each(|(value, spring)| *value *= spring);
    }
}

impl Preconditioner for Sprung<'_> {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let unknowns = self.constraints.columns();
        let mut lifted = work.copy(r);
        let (force, rest) = lifted.split_at_mut(unknowns);
        let gaps = rest.len() - self.springs.len();
        let mut values = work.copy(&rest[gaps..]);
        self.pull(&mut values);
        self.constraints.add_transposed(1.0, &values, force, work);
        self.inner.apply(&lifted, z, work);
        let (moved, multipliers) = z.split_at_mut(unknowns);
        self.constraints.apply(moved, &mut values, work);
        self.pull(&mut values);
        let own = multipliers[gaps..].iter_mut().zip(&values);
        own.for_each(|(multiplier, value)| *multiplier += value);
        work.give(values);
        work.give(lifted);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::samples::rows;

    /// Three equations, solved by elimination without pivoting.
    struct Exact([[f64; 3]; 3]);

    impl Preconditioner for Exact {
        fn apply(&self, r: &[f64], z: &mut [f64], _work: &mut Workspace) {
            let mut matrix = self.0;
            z.copy_from_slice(r);
            for pivot in 0..3 {
                for row in (0..3).filter(|&row| row != pivot) {
                    let factor = matrix[row][pivot] / matrix[pivot][pivot];
                    for column in 0..3 {
                        matrix[row][column] -= factor * matrix[pivot][column];
                    }
                    z[row] -= factor * z[pivot];
                }
            }
            (0..3).for_each(|row| z[row] /= matrix[row][row]);
        }
    }

    #[test]
    fn an_exact_inverse_of_the_body_on_springs_solves_the_body_without() {
        // A = diag(2, 3), C = [1, -2], W = 5 in the weights of the face.
        let (spring, c) = (5.0, [1.0, -2.0]);
        let weighted = c.map(|c| GAP_WEIGHT * c);
        let constraints = rows(&[weighted]);
        let on_springs = |i: usize, j: usize| spring * c[i] * c[j];
        let inner = Exact([
            [2.0 + on_springs(0, 0), on_springs(0, 1), weighted[0]],
            [on_springs(1, 0), 3.0 + on_springs(1, 1), weighted[1]],
            [weighted[0], weighted[1], 0.0],
        ]);
        let springs = on_the_face(&[spring], &[], &[Status::Stick]);
        let step = Sprung {
            inner: &inner,
            constraints: &constraints,
            springs: &springs,
        };
        let (r, mut z) = ([0.7, -0.2, 0.4], [0.0; 3]);
        step.apply(&r, &mut z, &mut Workspace::new());
        let left = [
            r[0] - 2.0 * z[0] - weighted[0] * z[2],
            r[1] - 3.0 * z[1] - weighted[1] * z[2],
            r[2] - weighted[0] * z[0] - weighted[1] * z[1],
        ];
        assert!(left.iter().all(|left| left.abs() < 1e-13), "{left:?}");
    }

    #[test]
    fn springs_off_the_face_do_not_pull() {
        let springs = on_the_face(&[4.0, 4.0], &[1.0, 2.0], &[Status::Open, Status::Stick]);
        let expected = 0.5 * 4.0 / (2.0 * GAP_WEIGHT).powi(2);
        assert!(springs[0].abs() < f64::EPSILON && (springs[1] - expected).abs() < 1e-15);
    }
}
