//! Conjugate projected gradient on the multiplier, scaled by the lumped mass W:
//!
//! ```text
//! r = -gap where it may act,  z = W^-1 r,  d = z + beta d,  l <- P(l + (r.d / d.K d) d),
//! ```
//!
//! P the projection on the set, which lower bounds alone make: l >= 0 in contact.
//! beta of Polak and Ribiere while the set stays, zero behind a projection. What
//! acts: gaps under pressure, and negative ones. The method that the seed gives
//! for contact (Fortin and El Maliki 2007); the scaling cures the shape of the
//! faces and leaves a condition of 1/h, so that the products grow like h^-1/2.
//! One product a step, one more behind a projection.

use super::clip::clip;
use signorini::inequality::condensed::Condensed;
use signorini::inequality::{
    BlockIterate, InequalitySolver, QpIterate, QpOutcome, QpProblem, QpRun, QpStatus,
};
use signorini::krylov::Outcome;
use signorini::linalg::vector::{dot, scale_and_add};

/// Products per problem; a tenth of it is usual.
const MOST_PRODUCTS: u32 = 400;

/// The method on a problem.
pub(crate) struct ConjugateProjectedGradient<'a> {
    /// The quadratic program; its contact set must be one of lower bounds, scaled by
    /// weights.
    pub(crate) problem: QpProblem<'a>,
}

/// What the next direction needs of the last step.
struct Last {
    /// The last direction of the multiplier `[multipliers]`.
    direction: Vec<f64>,
    /// The residual in the face at the last step `[multipliers]`; zero at bounds that
    /// hold.
    residual: Vec<f64>,
    /// r . W^-1 r of that residual: the square that the next conjugate direction is
    /// weighed against.
    square: f64,
}

impl InequalitySolver for ConjugateProjectedGradient<'_> {
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome {
        let mut last = None;
        Condensed::solve(
            &self.problem,
            run,
            MOST_PRODUCTS,
            iterate,
            |iterate, condensed| step(&mut last, iterate, condensed),
        )
    }
}

/// One conjugate gradient step of the multiplier, cut where a bound is met. Cost: one
/// product with the exact compliance.
fn step(
    last: &mut Option<Last>,
    iterate: &mut QpIterate,
    condensed: &mut Condensed<'_, '_, '_>,
) -> Result<(), QpStatus> {
    let block = condensed.contact();
    let least = block.set.lower_bounds().ok_or(QpStatus::Unsupported)?;
    let contact = &iterate.blocks[condensed.place()];
    let next = direction(contact, block.weights, &least, last.take());
    let response = condensed.product(next.direction.clone())?;
    let curvature = dot(&response.direction, &response.opening);
    if curvature.is_nan() || curvature <= 0.0 {
        return Err(QpStatus::Krylov(Outcome::Stagnation));
    }
    let length = dot(&next.residual, &next.direction) / curvature;
    condensed.advance(iterate, response, length);
    if !clip(condensed, iterate)? {
        *last = Some(next);
    }
    Ok(())
}

/// The next direction: the residual over the weights, made conjugate to the last
/// direction unless the free set has changed since. Multipliers at their bound take
/// part only where they want to leave it.
fn direction(contact: &BlockIterate, weights: &[f64], least: &[f64], last: Option<Last>) -> Last {
    let pairs = contact.residual.iter().zip(&contact.multiplier).zip(least);
    let residual: Vec<f64> = pairs
        .map(|((&gap, l), least)| if l > least || gap < 0.0 { -gap } else { 0.0 })
        .collect();
    let scaled: Vec<f64> = residual.iter().zip(weights).map(|(r, w)| r / w).collect();
    let square = dot(&residual, &scaled);
    let mut direction = scaled.clone();
    if let Some(last) = last {
        let beta = (square - dot(&last.residual, &scaled)) / last.square;
        if beta > 0.0 {
            direction = last.direction;
            scale_and_add(&mut direction, beta, &scaled);
        }
    }
    for ((d, l), least) in direction.iter_mut().zip(&contact.multiplier).zip(least) {
        *d = if l > least { *d } else { d.max(0.0) };
    }
    if dot(&residual, &direction) <= 0.0 {
        direction = scaled;
    }
    Last {
        direction,
        residual,
        square,
    }
}
