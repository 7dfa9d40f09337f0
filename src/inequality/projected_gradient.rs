//! Conjugate projected gradient on the multiplier, scaled by the lumped mass W:
//!
//! ```text
//! r = -gap where it may act,  z = W^-1 r,  d = z + beta d,  l <- max(0, l + (r.d / d.K d) d),
//! ```
//!
//! beta of Polak and Ribiere while the set stays, zero behind a projection. What
//! acts: gaps under pressure, and negative ones. The method that the seed gives
//! for contact (Fortin and El Maliki 2007); the scaling cures the shape of the
//! faces and leaves a condition of 1/h, so that the products grow like h^-1/2.
//! One product a step, one more behind a projection.

use super::condensed::Condensed;
use super::{InequalitySolver, QpIterate, QpOutcome, QpProblem, QpRun, QpStatus};
use crate::krylov::Outcome;
use crate::linalg::vector::{dot, scale_and_add};

/// Products per problem; a tenth of it is usual.
const MOST_PRODUCTS: u32 = 400;

/// The method on a problem.
pub struct ConjugateProjectedGradient<'a> {
    pub(super) problem: QpProblem<'a>,
}

/// What the next direction needs of the last step.
struct Last {
    direction: Vec<f64>,
    residual: Vec<f64>,
    /// r . W^-1 r.
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
            |iterate, condensed| self.step(&mut last, iterate, condensed),
        )
    }
}

impl ConjugateProjectedGradient<'_> {
    fn step(
        &self,
        last: &mut Option<Last>,
        iterate: &mut QpIterate,
        condensed: &mut Condensed<'_, '_, '_>,
    ) -> Result<(), QpStatus> {
        let next = self.direction(iterate, last.take());
        let response = condensed.product(next.direction.clone())?;
        let curvature = dot(&response.direction, &response.opening);
        if curvature.is_nan() || curvature <= 0.0 {
            return Err(QpStatus::Krylov(Outcome::Stagnation));
        }
        let length = dot(&next.residual, &next.direction) / curvature;
        condensed.advance(iterate, response, length);
        if !condensed.clip(iterate)? {
            *last = Some(next);
        }
        Ok(())
    }

    fn direction(&self, iterate: &QpIterate, last: Option<Last>) -> Last {
        let pairs = iterate.gap.iter().zip(&iterate.multiplier);
        let acts = |(&gap, &l): (&f64, &f64)| if l > 0.0 || gap < 0.0 { -gap } else { 0.0 };
        let residual: Vec<f64> = pairs.map(acts).collect();
        let scaled: Vec<f64> = residual
            .iter()
            .zip(self.problem.weights)
            .map(|(r, w)| r / w)
            .collect();
        let square = dot(&residual, &scaled);
        let mut direction = scaled.clone();
        if let Some(last) = last {
            let beta = (square - dot(&last.residual, &scaled)) / last.square;
            if beta > 0.0 {
                direction = last.direction;
                scale_and_add(&mut direction, beta, &scaled);
            }
        }
        for (d, l) in direction.iter_mut().zip(&iterate.multiplier) {
            *d = if *l > 0.0 { *d } else { d.max(0.0) };
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
}
