//! Projected steps in a metric that learns:
//!
//! ```text
//! x = argmin { 1/2 |x - l|_H^2 + gap(l).x : x >= 0 },  d = x - l,
//! l <- l + t d,  t the exact minimum along d that keeps l >= 0,
//! H <- H - H d d^T H / d.H d + K d d^T K / d.K d.
//! ```
//!
//! H starts as the metric of the problem; each product K d that is paid for
//! corrects it, so that the small dense problem acts on the subspace of all
//! earlier steps with the exact compliance (Broyden, Fletcher, Goldfarb, Shanno;
//! for sequences of contact problems: Mercier, Gratton, Tardieu and Vasseur,
//! Comput. Mech. 2017). One product a step, whatever the mesh size.

use super::condensed::{Condensed, Response};
use super::metric::nearest;
use super::{InequalitySolver, QpIterate, QpOutcome, QpProblem, QpRun, QpStatus};
use crate::krylov::Outcome;
use crate::linalg::DenseMatrix;
use crate::linalg::vector::{add_scaled, dot};

/// Products per problem; a tenth of it is usual.
const MOST_PRODUCTS: u32 = 200;

/// The method on a problem.
pub struct Nested<'a> {
    pub(super) problem: QpProblem<'a>,
}

impl InequalitySolver for Nested<'_> {
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome {
        let mut metric = self.problem.metric.clone();
        Condensed::solve(
            &self.problem,
            run,
            MOST_PRODUCTS,
            iterate,
            |iterate, condensed| step(&mut metric, iterate, condensed),
        )
    }
}

fn step(
    metric: &mut DenseMatrix,
    iterate: &mut QpIterate,
    condensed: &mut Condensed<'_, '_, '_>,
) -> Result<(), QpStatus> {
    let mut change = nearest(metric, iterate)?.values;
    add_scaled(&mut change, -1.0, &iterate.multiplier);
    let slope = dot(&iterate.gap, &change);
    let response = condensed.product(change)?;
    let curvature = dot(&response.direction, &response.opening);
    if slope >= 0.0 || curvature.is_nan() || curvature <= 0.0 {
        return Err(QpStatus::Krylov(Outcome::Stagnation));
    }
    let length = (-slope / curvature).min(longest(iterate, &response.direction));
    learn(metric, &response, curvature);
    condensed.advance(iterate, response, length);
    condensed.clip(iterate)?;
    Ok(())
}

/// The longest step along `direction` that keeps the multiplier non-negative;
/// the step to the target does.
pub(super) fn longest(iterate: &QpIterate, direction: &[f64]) -> f64 {
    let pairs = iterate.multiplier.iter().zip(direction);
    pairs
        .filter(|&(_, &d)| d < 0.0)
        .map(|(l, d)| -l / d)
        .fold(f64::INFINITY, f64::min)
}

/// Gives the metric the product along the direction of `response`.
fn learn(metric: &mut DenseMatrix, response: &Response, curvature: f64) {
    let (d, opening) = (&response.direction, &response.opening);
    let mut old = vec![0.0; d.len()];
    metric.multiply(d, &mut old);
    let before = dot(d, &old);
    for j in 0..d.len() {
        let (a, b) = (opening[j] / curvature, old[j] / before);
        let column = metric.column_mut(j).iter_mut();
        for ((value, y), h) in column.zip(opening).zip(&old) {
            *value += a * y - b * h;
        }
    }
}
