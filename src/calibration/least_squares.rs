//! Levenberg-Marquardt with bounds: sum of squares of residuals that depend on a few numbers.
//!
//! ```text
//! (J^T J + d diag(J^T J)) s = -J^T r   on numbers that are not held at a bound
//! x <- x + s, cut to the bounds, where that does not raise the sum; else d grows
//! ```
//!
//! J by central differences. Where the residuals vanish the last steps are those of Newton's
//! method. Reference: J. J. More, The Levenberg-Marquardt algorithm, Lecture Notes in Mathematics
//! 630 (1978). Cost: 2 n + 1 evaluations an iteration for n numbers.

use crate::linalg::{DenseCholesky, DenseMatrix};

/// Most iterations; chosen: most fits take 5 to 60, three terms of Ogden's law up to some 500.
const ITERATIONS: usize = 1000;
/// Step of the differences over the size of a number: that of central differences in double
/// precision (1e-16 to the power 1/3).
const STEP: f64 = 1e-5;
/// Change of all numbers, over their sizes, at which they are found; chosen below the 1e-6 to
/// which constants of exact curves come back.
const FOUND: f64 = 1e-11;
/// Damping at first, and above which there is no lower sum.
const DAMPING: [f64; 2] = [1e-3, 1e12];

/// A number that is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unknown {
    /// Where it may be.
    pub(super) bounds: [f64; 2],
    /// Its size where it is zero, for differences.
    pub(super) size: f64,
}

/// Residuals as functions of numbers; none where these are not allowed.
pub(super) type Residuals<'a> = dyn Fn(&[f64]) -> Option<Vec<f64>> + 'a;

/// Where the sum of squares is least.
#[derive(Clone, Debug)]
pub(super) struct Minimum {
    /// The numbers.
    pub(super) at: Vec<f64>,
    /// Sum of the squares there.
    pub(super) sum: f64,
    /// J there, a column a number `[numbers][residuals]`.
    pub(super) slopes: Vec<Vec<f64>>,
}

/// The residuals at `at`, finite, and their sum of squares.
fn evaluate(residuals: &Residuals<'_>, at: &[f64]) -> Option<(Vec<f64>, f64)> {
    let values = residuals(at)?;
    let sum: f64 = values.iter().map(|r| r * r).sum();
    sum.is_finite().then_some((values, sum))
}

/// J by central differences, one-sided at a bound.
fn slopes(residuals: &Residuals<'_>, unknowns: &[Unknown], at: &[f64]) -> Option<Vec<Vec<f64>>> {
    let column = |(place, unknown): (usize, &Unknown)| {
        let step = STEP * at[place].abs().max(unknown.size);
        let [low, high] = unknown.bounds;
        let ends = [(at[place] - step).max(low), (at[place] + step).min(high)];
        let [before, after] = ends.map(|value| {
            let mut moved = at.to_vec();
            moved[place] = value;
            evaluate(residuals, &moved)
        });
        let ((before, _), (after, _)) = (before?, after?);
        let pairs = after.iter().zip(&before);
        Some(pairs.map(|(a, b)| (a - b) / (ends[1] - ends[0])).collect())
    };
    unknowns.iter().enumerate().map(column).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// J^T J of some columns, its diagonal scaled to `1 + damping`, and the scales.
fn normal(slopes: &[Vec<f64>], free: &[usize], damping: f64) -> (DenseMatrix, Vec<f64>) {
    let scales = free.iter().map(|&i| dot(&slopes[i], &slopes[i]).sqrt());
    let scales: Vec<f64> = scales.map(|scale| scale.max(f64::MIN_POSITIVE)).collect();
    let mut matrix = DenseMatrix::zeros(free.len(), free.len());
    for (row, &i) in free.iter().enumerate() {
        for (column, &j) in free.iter().enumerate() {
            *matrix.at_mut(row, column) =
                dot(&slopes[i], &slopes[j]) / (scales[row] * scales[column]);
        }
        *matrix.at_mut(row, row) += damping;
    }
    (matrix, scales)
}

/// Diagonal of the inverse of J^T J on the numbers that are not at a bound `[numbers]`; none for
/// numbers at a bound and for those that the residuals do not determine.
pub(super) fn variances(minimum: &Minimum, unknowns: &[Unknown]) -> Vec<Option<f64>> {
    let is_free = |&i: &usize| {
        let [low, high] = unknowns[i].bounds;
        minimum.at[i] > low && minimum.at[i] < high
    };
    let free: Vec<usize> = (0..unknowns.len()).filter(is_free).collect();
    let mut found = vec![None; unknowns.len()];
    if free.is_empty() {
        return found;
    }
    let (matrix, scales) = normal(&minimum.slopes, &free, 0.0);
    if let Ok(factor) = DenseCholesky::new(&matrix) {
        let inverse = factor.inverse();
        for (place, &i) in free.iter().enumerate() {
            let variance = inverse.at(place, place) / (scales[place] * scales[place]);
            found[i] = (variance.is_finite() && variance > 0.0).then_some(variance);
        }
    }
    found
}

/// The step of those numbers that are free to move, against the slope of the sum.
pub(super) fn step(
    (slopes, values): (&[Vec<f64>], &[f64]),
    (unknowns, at): (&[Unknown], &[f64]),
    damping: f64,
) -> Option<Vec<f64>> {
    let slope: Vec<f64> = slopes.iter().map(|column| dot(column, values)).collect();
    let is_free = |&i: &usize| {
        let [low, high] = unknowns[i].bounds;
        let is_held = (at[i] <= low && slope[i] > 0.0) || (at[i] >= high && slope[i] < 0.0);
        !is_held && slopes[i].iter().any(|s| *s != 0.0)
    };
    let free: Vec<usize> = (0..at.len()).filter(is_free).collect();
    if free.is_empty() {
        return None;
    }
    let (matrix, scales) = normal(slopes, &free, damping);
    let factor = DenseCholesky::new(&matrix).ok()?;
    let right = free
        .iter()
        .zip(&scales)
        .map(|(&i, scale)| -slope[i] / scale);
    let mut right: Vec<f64> = right.collect();
    factor.solve(&mut right);
    let mut step = vec![0.0; at.len()];
    for ((&i, value), scale) in free.iter().zip(right).zip(&scales) {
        step[i] = value / scale;
    }
    Some(step)
}

/// The least sum of squares near `start`; none where the residuals are not there.
pub(super) fn minimise(
    residuals: &Residuals<'_>,
    unknowns: &[Unknown],
    start: &[f64],
) -> Option<Minimum> {
    let cut = |at: Vec<f64>| -> Vec<f64> {
        let pairs = at.into_iter().zip(unknowns);
        pairs
            .map(|(x, one)| x.clamp(one.bounds[0], one.bounds[1]))
            .collect()
    };
    let mut at = cut(start.to_vec());
    let (mut values, mut sum) = evaluate(residuals, &at)?;
    let mut columns = slopes(residuals, unknowns, &at)?;
    let mut damping = DAMPING[0];
    for _ in 0..ITERATIONS {
        let step = step((&columns, &values), (unknowns, &at), damping);
        let trial = step.map(|step| cut(at.iter().zip(step).map(|(x, s)| x + s).collect()));
        let next = trial.and_then(|trial| Some((evaluate(residuals, &trial)?, trial)));
        match next.filter(|((_, lower), _)| *lower <= sum) {
            Some(((new_values, lower), trial)) => {
                let moved = at.iter().zip(&trial).zip(unknowns);
                let is_found = moved
                    .map(|((x, y), one)| (y - x).abs() / y.abs().max(one.size))
                    .all(|change| change < FOUND);
                (values, sum, at) = (new_values, lower, trial);
                columns = slopes(residuals, unknowns, &at)?;
                damping = (0.2 * damping).max(f64::EPSILON);
                if is_found {
                    break;
                }
            }
            None => damping *= 3.0,
        }
        if damping > DAMPING[1] {
            break;
        }
    }
    Some(Minimum {
        at,
        sum,
        slopes: columns,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ANY: Unknown = Unknown {
        bounds: [f64::NEG_INFINITY, f64::INFINITY],
        size: 1.0,
    };

    #[test]
    fn the_valley_of_rosenbrock_ends_where_it_is_known_to() {
        let residuals = |x: &[f64]| Some(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]);
        let found = minimise(&residuals, &[ANY; 2], &[-1.2, 1.0]).expect("it is defined");
        assert!(
            found.at.iter().all(|x| (x - 1.0).abs() < 1e-9),
            "{:?}",
            found.at
        );
        assert!(found.sum < 1e-18);
    }

    #[test]
    fn a_bound_holds_a_number_and_the_others_follow() {
        let residuals = |x: &[f64]| Some(vec![x[0] - 3.0, x[1] - x[0]]);
        let low = Unknown {
            bounds: [0.0, 2.0],
            ..ANY
        };
        let found = minimise(&residuals, &[low, ANY], &[1.0, 5.0]).expect("it is defined");
        assert!((found.at[0] - 2.0).abs() < 1e-12 && (found.at[1] - 2.0).abs() < 1e-9);
        assert_eq!(variances(&found, &[low, ANY])[0], None);
    }

    #[test]
    fn numbers_that_nothing_depends_on_have_no_variance() {
        let residuals = |x: &[f64]| Some(vec![x[0] - 3.0, 2.0 * x[0] - 5.0]);
        let found = minimise(&residuals, &[ANY; 2], &[1.0, 7.0]).expect("it is defined");
        assert!((found.at[0] - 2.6).abs() < 1e-9 && (found.at[1] - 7.0).abs() < 1e-12);
        assert_eq!(variances(&found, &[ANY; 2]), [None, None]);
    }
}
