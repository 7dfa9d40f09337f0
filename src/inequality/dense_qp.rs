//! min 1/2 x^T K x + q^T x, x >= 0, for a small dense positive definite K.
//!
//! Block principal pivoting: all infeasible indices change sides at once; when
//! their number does not fall for some passes, single pivots by Murty's rule
//! guarantee the end (Judice and Pires, Comput. Oper. Res. 21, 1994). Usually 2
//! to 8 passes, each one Cholesky factor of the free part.

use crate::linalg::{DenseCholesky, DenseMatrix, FactoriseError};

/// Why there is no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DenseQpError {
    /// A principal part cannot be factorised.
    #[error(transparent)]
    Factorise(#[from] FactoriseError),
    /// Rounding keeps the pivots from ending.
    #[error("the pivots do not end")]
    PivotLimit,
}

/// Block passes without progress before single pivots.
const PATIENCE: usize = 3;
/// Passes in all; far above what occurs.
const LIMIT: usize = 2000;
/// Multipliers and gaps this small against the largest count as zero.
const RELATIVE_ZERO: f64 = 1e-13;

/// The solution and its free set.
#[derive(Clone, Debug, PartialEq)]
pub struct DenseSolution {
    /// x.
    pub values: Vec<f64>,
    /// Where x may be positive.
    pub free: Vec<bool>,
}

/// Solves the problem, starting from the set `guess`.
///
/// # Errors
/// [`DenseQpError`] when `matrix` is not positive definite or too ill-conditioned.
pub fn solve(
    matrix: &DenseMatrix,
    linear: &[f64],
    guess: &[bool],
) -> Result<DenseSolution, DenseQpError> {
    let mut free = guess.to_vec();
    let mut fewest = usize::MAX;
    let mut patience = PATIENCE;
    for _ in 0..LIMIT {
        let values = values_on(matrix, linear, &free)?;
        let wrong = infeasible(matrix, linear, &free, &values);
        if wrong.is_empty() {
            return Ok(DenseSolution { values, free });
        }
        if wrong.len() < fewest {
            fewest = wrong.len();
            patience = PATIENCE;
        } else {
            patience = patience.saturating_sub(1);
        }
        match (patience, wrong.last()) {
            (0, Some(&last)) => free[last] = !free[last],
            _ => wrong.iter().for_each(|&index| free[index] = !free[index]),
        }
    }
    Err(DenseQpError::PivotLimit)
}

fn values_on(
    matrix: &DenseMatrix,
    linear: &[f64],
    free: &[bool],
) -> Result<Vec<f64>, FactoriseError> {
    let selected: Vec<usize> = (0..free.len()).filter(|&i| free[i]).collect();
    let mut solution: Vec<f64> = selected.iter().map(|&i| -linear[i]).collect();
    DenseCholesky::new(&matrix.principal(&selected))?.solve(&mut solution);
    let mut values = vec![0.0; free.len()];
    for (&index, value) in selected.iter().zip(solution) {
        values[index] = value;
    }
    Ok(values)
}

fn infeasible(matrix: &DenseMatrix, linear: &[f64], free: &[bool], values: &[f64]) -> Vec<usize> {
    let mut slope = vec![0.0; linear.len()];
    matrix.multiply(values, &mut slope);
    slope.iter_mut().zip(linear).for_each(|(s, q)| *s += q);
    let zero = RELATIVE_ZERO * crate::linalg::vector::largest(linear);
    let small = RELATIVE_ZERO * crate::linalg::vector::largest(values);
    (0..free.len())
        .filter(|&i| match free[i] {
            true => values[i] < -small,
            false => slope[i] < -zero,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn positive_definite(entries: &[f64], size: usize) -> DenseMatrix {
        let mut matrix = DenseMatrix::zeros(size, size);
        for i in 0..size {
            for j in 0..size {
                let row = |k: usize| entries[k * size..(k + 1) * size].iter();
                let product: f64 = row(i).zip(row(j)).map(|(a, b)| a * b).sum();
                *matrix.at_mut(i, j) = product + if i == j { 0.1 } else { 0.0 };
            }
        }
        matrix
    }

    proptest! {
        #[test]
        fn the_solution_satisfies_the_optimality_conditions(
            entries in proptest::collection::vec(-1.0..1.0_f64, 36),
            linear in proptest::collection::vec(-1.0..1.0_f64, 6),
            guess in proptest::collection::vec(any::<bool>(), 6),
        ) {
            let matrix = positive_definite(&entries, 6);
            let solution = solve(&matrix, &linear, &guess).expect("positive definite");
            let mut slope = vec![0.0; 6];
            matrix.multiply(&solution.values, &mut slope);
            for i in 0..6 {
                let s = slope[i] + linear[i];
                prop_assert!(solution.values[i] >= -1e-10);
                prop_assert!(s >= -1e-10);
                prop_assert!((s * solution.values[i]).abs() < 1e-10);
            }
        }
    }
}
