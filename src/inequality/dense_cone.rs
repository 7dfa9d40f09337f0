//! min 1/2 x^T K x + q^T x over a product of admissible sets, for a small dense
//! positive definite K.
//!
//! Lines and half lines, the multipliers of contact, go by block principal pivoting:
//! all infeasible indices change sides at once; when their number does not fall for
//! some passes, single pivots by Murty's rule guarantee the end (Judice and Pires,
//! Comput. Oper. Res. 21, 1994). Usually 2 to 8 passes, each one Cholesky factor of
//! the closed part. Points of other sets, the discs of friction with given thresholds, go by
//! block Gauss-Seidel around it: `sweep`. Where thresholds follow from pressures Newton's
//! method solves for both: `friction`.

mod friction;
mod pivot;
mod sweep;
mod uniqueness;

pub use friction::cones;
pub(super) use friction::newton_face;
pub use uniqueness::{Uniqueness, uniqueness};

use crate::linalg::{FactoriseError, SymmetricMatrix};
use crate::saddle::{ProductSet, Status};

/// Why there is no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DenseConeError {
    /// A principal part of the matrix has no Cholesky factor: the metric is not
    /// positive definite.
    #[error(transparent)]
    Factorise(#[from] FactoriseError),
    /// The pivots come back to earlier sides because of rounding, up to a limit.
    #[error("the pivots do not end")]
    PivotLimit,
    /// Newton's method for friction has found no solution.
    #[error("Newton's method does not converge")]
    NewtonLimit,
    /// The sweeps over the points have not converged.
    #[error("the sweeps do not converge")]
    SweepLimit,
}

/// Multipliers and gaps this small against the largest count as zero.
const RELATIVE_ZERO: f64 = 1e-13;

/// The solution and what each multiplier does there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DenseSolution {
    /// The solution x `[multipliers]`.
    pub values: Vec<f64>,
    /// What each multiplier does at the solution `[multipliers]`.
    pub status: Vec<Status>,
    /// Residual at the solution, where there is friction; empty without `[multipliers]`.
    pub slip: Vec<f64>,
    /// Steps of Newton's method for friction that led to it; zero without friction.
    pub steps: u32,
}

impl DenseSolution {
    /// Whether every multiplier is closed or open: none slips.
    pub(super) fn is_of_contact(&self) -> bool {
        !self.status.contains(&Status::Slip)
    }
}

/// The problem.
#[derive(Clone, Copy)]
pub(super) struct DenseProblem<'a> {
    /// K, symmetric and positive definite `[multipliers, multipliers]`.
    pub(super) matrix: &'a dyn SymmetricMatrix,
    /// q, the linear term `[multipliers]`.
    pub(super) linear: &'a [f64],
    /// The product of sets in which x lies; its sizes add up to those of K.
    pub(super) set: ProductSet<'a>,
}

/// Solves the problem, starting from the statuses `guess`.
///
/// Friction starts from `near` `[multipliers]`, too: it may have several solutions, and that
/// one is sought.
///
/// # Errors
/// [`DenseConeError`] when `matrix` is not positive definite or too ill-conditioned.
pub fn solve(
    matrix: &dyn SymmetricMatrix,
    linear: &[f64],
    set: ProductSet<'_>,
    (guess, near): (&[Status], &[f64]),
) -> Result<DenseSolution, DenseConeError> {
    let problem = DenseProblem {
        matrix,
        linear,
        set,
    };
    if let Some(cones) = cones(&set) {
        return friction::solve(&problem, cones, (guess, near));
    }
    let mut pivots = pivot::Pivots::new(set, guess);
    match set.lower_bounds() {
        Some(_) => {
            let values = pivots.solve(matrix, linear)?;
            Ok(DenseSolution {
                values,
                status: pivots.status(),
                ..DenseSolution::default()
            })
        }
        None => sweep::solve(&problem, &mut pivots),
    }
}

#[cfg(test)]
mod half_space;
#[cfg(test)]
mod tests;
