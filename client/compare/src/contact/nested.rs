//! Projected steps in a metric that learns:
//!
//! ```text
//! x = argmin { 1/2 |x - l|_H^2 + gap(l).x : x in the set },  d = x - l,
//! l <- l + t d,  t the exact minimum along d within the set,
//! H <- H - H d d^T H / d.H d + K d d^T K / d.K d.
//! ```
//!
//! H starts as the metric of the problem; each product K d that is paid for
//! corrects it, so that the small dense problem acts on the subspace of all
//! earlier steps with the exact compliance (Broyden, Fletcher, Goldfarb, Shanno;
//! for sequences of contact problems: Mercier, Gratton, Tardieu and Vasseur,
//! Comput. Mech. 2017). One product a step, whatever the mesh size.

use super::clip::clip;
use signorini::inequality::condensed::{Condensed, Response};
use signorini::inequality::metric::nearest;
use signorini::inequality::{InequalitySolver, QpIterate, QpOutcome, QpProblem, QpRun, QpStatus};
use signorini::krylov::Outcome;
use signorini::linalg::DenseMatrix;
use signorini::linalg::vector::{add_scaled, dot};

/// Products per problem; a tenth of it is usual.
const MOST_PRODUCTS: u32 = 200;

/// The method on a problem.
pub(crate) struct Nested<'a> {
    /// The quadratic program; its contact block has a dense metric, which each product
    /// corrects.
    pub(crate) problem: QpProblem<'a>,
}

impl InequalitySolver for Nested<'_> {
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome {
        let mut metric = None;
        Condensed::solve(
            &self.problem,
            run,
            MOST_PRODUCTS,
            iterate,
            |iterate, condensed| {
                let metric = metric.get_or_insert_with(|| condensed.contact().matrix.dense());
                step(metric, iterate, condensed)
            },
        )
    }
}

/// Goes to the minimum of the energy along the way to the solution of the dense problem
/// in `metric`, which then learns what the product with the exact compliance has told
/// (a secant correction).
fn step(
    metric: &mut DenseMatrix,
    iterate: &mut QpIterate,
    condensed: &mut Condensed<'_, '_, '_>,
) -> Result<(), QpStatus> {
    let set = condensed.contact().set;
    let contact = &iterate.blocks[condensed.place()];
    let mut change = nearest(metric, set, contact)?.values;
    add_scaled(&mut change, -1.0, &contact.multiplier);
    let slope = dot(&contact.residual, &change);
    let response = condensed.product(change)?;
    let curvature = dot(&response.direction, &response.opening);
    if slope >= 0.0 || curvature.is_nan() || curvature <= 0.0 {
        return Err(QpStatus::Krylov(Outcome::Stagnation));
    }
    // The step to the target stays in the set, a longer one need not.
    let longest = set.longest_step(&contact.multiplier, &response.direction);
    let length = (-slope / curvature).min(longest);
    learn(metric, &response, curvature);
    condensed.advance(iterate, response, length);
    clip(condensed, iterate)?;
    Ok(())
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
