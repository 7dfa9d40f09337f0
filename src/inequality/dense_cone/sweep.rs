//! Block Gauss-Seidel for sets whose points are solved one by one:
//!
//! ```text
//! repeat: lines and half lines together by pivots, then each point p exactly:
//!         min 1/2 t.K_pp t + (q_p + sum of K_pj x_j over j outside p).t,  t in its set
//! ```
//!
//! Converges for every positive definite K: each part is minimised exactly over a
//! product of convex sets. The number of sweeps grows with the coupling of the
//! points; a sweep costs a product with K and one pass of the pivots.

use super::pivot::Pivots;
use super::{DenseConeError, DenseProblem, DenseSolution, RELATIVE_ZERO};
use crate::linalg::DenseMatrix;
use crate::linalg::vector::{add_scaled, largest};
use crate::saddle::{Admissible, Kind, PairProblem, PointSet};
use std::ops::Range;

/// Sweeps in all; some tens are usual.
const LIMIT: usize = 5000;

/// Solves the problem from zero at the points and the sides of `pivots` elsewhere.
///
/// # Errors
/// [`DenseConeError`] when K is not positive definite or the sweeps do not end.
pub(super) fn solve(
    problem: &DenseProblem<'_>,
    pivots: &mut Pivots,
) -> Result<DenseSolution, DenseConeError> {
    let matrix = problem.matrix.dense();
    let mut values = vec![0.0; problem.linear.len()];
    for _ in 0..LIMIT {
        let mut change = values.clone();
        pivot(problem, pivots, &mut values)?;
        let mut slope = slope(problem, &values);
        for (set, range) in problem.set.ranges() {
            if let Kind::Points(points) = set.kind() {
                visit(&matrix, points, range, (&mut values, &mut slope));
            }
        }
        add_scaled(&mut change, -1.0, &values);
        if largest(&change) <= RELATIVE_ZERO * largest(&values) {
            return Ok(solution(problem, pivots, values));
        }
    }
    Err(DenseConeError::SweepLimit)
}

/// q + K x.
fn slope(problem: &DenseProblem<'_>, x: &[f64]) -> Vec<f64> {
    let mut slope = vec![0.0; x.len()];
    problem.matrix.product(x, &mut slope);
    add_scaled(&mut slope, 1.0, problem.linear);
    slope
}

/// Lines and half lines under the present values of the points.
fn pivot(
    problem: &DenseProblem<'_>,
    pivots: &mut Pivots,
    values: &mut [f64],
) -> Result<(), DenseConeError> {
    let mut fixed = vec![0.0; values.len()];
    for range in point_ranges(problem) {
        fixed[range.clone()].copy_from_slice(&values[range]);
    }
    let linear = slope(problem, &fixed);
    let pivoted = pivots.solve(problem.matrix, &linear)?;
    values.copy_from_slice(&fixed);
    add_scaled(values, 1.0, &pivoted);
    Ok(())
}

/// The ranges of multipliers whose sets are products over points, each set one range.
fn point_ranges(problem: &DenseProblem<'_>) -> Vec<Range<usize>> {
    let ranges = problem.set.ranges();
    let points = ranges.filter(|(set, _)| matches!(set.kind(), Kind::Points(_)));
    points.map(|(_, range)| range).collect()
}

/// Solves each point of one part; `slope` follows.
fn visit(
    matrix: &DenseMatrix,
    points: &dyn PointSet,
    range: Range<usize>,
    (values, slope): (&mut [f64], &mut [f64]),
) {
    let width = points.width();
    for (point, first) in range.step_by(width).enumerate() {
        let pair = pair(matrix, first..first + width, values, slope);
        let next = points.minimise(point, &pair);
        for (index, next) in (first..first + width).zip(next) {
            let change = next - std::mem::replace(&mut values[index], next);
            add_scaled(slope, change, matrix.column(index));
        }
    }
}

/// The problem of one point, the others fixed.
fn pair(matrix: &DenseMatrix, range: Range<usize>, values: &[f64], slope: &[f64]) -> PairProblem {
    let mut pair = PairProblem {
        matrix: [[1.0, 0.0], [0.0, 1.0]],
        linear: [0.0; 2],
    };
    for (i, row) in range.clone().enumerate() {
        pair.linear[i] = slope[row];
        for (j, column) in range.clone().enumerate() {
            let entry = matrix.at(row, column);
            pair.matrix[i][j] = entry;
            pair.linear[i] -= entry * values[column];
        }
    }
    pair
}

/// The solution with its statuses: by side for pivoted multipliers, by their own set
/// for those of points.
fn solution(problem: &DenseProblem<'_>, pivots: &Pivots, values: Vec<f64>) -> DenseSolution {
    let mut status = pivots.status();
    for (set, range) in problem.set.ranges() {
        if let Kind::Points(_) = set.kind() {
            set.status(&values[range.clone()], &mut status[range]);
        }
    }
    DenseSolution {
        values,
        status,
        ..DenseSolution::default()
    }
}
