//! Block principal pivoting of the lines and half lines; other multipliers are zero.
//!
//! A pass factorises the closed part, m^3 / 3 flops, and changes the side of every index
//! with the wrong sign. When their number has not fallen for some passes only the last of
//! them changes sides, which ends after finitely many passes for every positive definite
//! matrix.

use super::{DenseConeError, RELATIVE_ZERO};
use crate::linalg::vector::largest;
use crate::linalg::{FactoriseError, SymmetricMatrix, Workspace};
use crate::saddle::{Admissible, Kind, ProductSet, Status};

/// Block passes without progress before single pivots.
const PATIENCE: usize = 3;
/// Passes in all; far above what occurs.
const LIMIT: usize = 2000;

/// Which multipliers are unknown, and which of them may change sides.
pub(super) struct Pivots {
    /// Whether each multiplier is unknown: closed, where its residual is zero.
    closed: Vec<bool>,
    /// Whether each multiplier may change sides; multipliers of free and of point sets
    /// may not.
    signed: Vec<bool>,
}

impl Pivots {
    /// On the side that `guess` names.
    pub(super) fn new(set: ProductSet<'_>, guess: &[Status]) -> Self {
        let mut closed: Vec<bool> = guess.iter().map(|status| status.is_closed()).collect();
        let mut signed = vec![false; guess.len()];
        for (set, range) in set.ranges() {
            match set.kind() {
                Kind::Line => closed[range].fill(true),
                Kind::HalfLine => signed[range].fill(true),
                Kind::Points(_) | Kind::Cones(_) => closed[range].fill(false),
            }
        }
        Self { closed, signed }
    }

    /// What each multiplier does.
    pub(super) fn status(&self) -> Vec<Status> {
        let closed = self.closed.iter().copied();
        closed.map(Status::of_contact).collect()
    }

    /// The minimum over the lines and half lines.
    ///
    /// # Errors
    /// [`DenseConeError`] when `matrix` is not positive definite or too ill-conditioned.
    pub(super) fn solve(
        &mut self,
        matrix: &dyn SymmetricMatrix,
        linear: &[f64],
    ) -> Result<Vec<f64>, DenseConeError> {
        let mut fewest = usize::MAX;
        let mut patience = PATIENCE;
        for _ in 0..LIMIT {
            let values = self.values(matrix, linear)?;
            let wrong = self.infeasible(matrix, linear, &values);
            if wrong.is_empty() {
                return Ok(values);
            }
            if wrong.len() < fewest {
                fewest = wrong.len();
                patience = PATIENCE;
            } else {
                patience = patience.saturating_sub(1);
            }
            // Murty's rule: one index alone, always the last one, cannot cycle. Blocks are
            // faster and may; they come back as soon as fewer indices are wrong than ever.
            match (patience, wrong.last()) {
                (0, Some(&last)) => self.change_side(last),
                _ => wrong.iter().for_each(|&index| self.change_side(index)),
            }
        }
        Err(DenseConeError::PivotLimit)
    }

    /// Opens a closed multiplier, or closes an open one.
    fn change_side(&mut self, index: usize) {
        self.closed[index] = !self.closed[index];
    }

    /// K x = -q on the closed multipliers, zero on the others.
    fn values(
        &self,
        matrix: &dyn SymmetricMatrix,
        linear: &[f64],
    ) -> Result<Vec<f64>, FactoriseError> {
        let count = self.closed.len();
        let selected: Vec<usize> = (0..count).filter(|&i| self.closed[i]).collect();
        let mut solution: Vec<f64> = selected.iter().map(|&i| -linear[i]).collect();
        matrix
            .factor_of_part(&selected)?
            .solve_part(&mut solution, &mut Workspace::new());
        let mut values = vec![0.0; count];
        for (&index, value) in selected.iter().zip(solution) {
            values[index] = value;
        }
        Ok(values)
    }

    /// Indices of the multipliers with the wrong sign on their side, ascending; what is
    /// zero to rounding is none. Cost: one dense product.
    fn infeasible(
        &self,
        matrix: &dyn SymmetricMatrix,
        linear: &[f64],
        values: &[f64],
    ) -> Vec<usize> {
        let mut slope = vec![0.0; linear.len()];
        matrix.product(values, &mut slope);
        slope.iter_mut().zip(linear).for_each(|(s, q)| *s += q);
        let small = RELATIVE_ZERO * largest(values);
        let roots: Vec<f64> = matrix.diagonal().into_iter().map(f64::sqrt).collect();
        let terms = values.iter().zip(&roots);
        let term = terms.fold(0.0_f64, |most, (x, root)| most.max(x.abs() * root));
        // Of what the row adds up, |K_ij| <= root(K_ii K_jj): a gap of large faces far away is
        // no measure of one of small faces.
        let zero = |i: usize| RELATIVE_ZERO * (linear[i].abs() + roots[i] * term);
        (0..self.closed.len())
            .filter(|&i| self.signed[i])
            .filter(|&i| {
                if self.closed[i] {
                    values[i] < -small
                } else {
                    slope[i] < -zero(i)
                }
            })
            .collect()
    }
}
