//! Projected Arrow-Hurwicz: fixed steps of the multiplier, projected in its
//! metric H,
//!
//! ```text
//! l <- argmin { 1/2 |x - l|_H^2 + gap(l).x : x >= 0 },
//! ```
//!
//! displacement and equality unknowns brought to balance after each. The metric
//! is scaled so that H >= K about, which makes the step contract, by about
//! 1 - 1 / cond(H^-1 K). Steps half as long again diverge in the compliance.
//! In the mass the condition grows like 1/h, in the
//! compliance it does not. One product a step and one small dense problem.
//! Arrow, Hurwicz and Uzawa, Studies in Linear and Nonlinear Programming, 1958.

use super::condensed::Condensed;
use super::metric::nearest;
use super::{InequalitySolver, QpIterate, QpOutcome, QpProblem, QpRun, QpStatus};

/// Products per problem. In the mass they do not suffice for six digits on more
/// than some tens of candidates; the outcome then says so.
const MOST_PRODUCTS: u32 = 400;

/// The method on a problem.
pub struct ProjectedArrowHurwicz<'a> {
    pub(super) problem: QpProblem<'a>,
}

impl InequalitySolver for ProjectedArrowHurwicz<'_> {
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome {
        let mut condensed = match Condensed::start(&self.problem, run, MOST_PRODUCTS, iterate) {
            Ok(condensed) => condensed,
            Err(outcome) => return outcome,
        };
        let status = self.steps(iterate, &mut condensed);
        condensed.finish(status.unwrap_or_else(|failed| failed))
    }
}

impl ProjectedArrowHurwicz<'_> {
    fn steps(
        &self,
        iterate: &mut QpIterate,
        condensed: &mut Condensed<'_, '_, '_>,
    ) -> Result<QpStatus, QpStatus> {
        loop {
            if let Some(status) = condensed.ended(iterate) {
                return Ok(status);
            }
            let target = nearest(self.problem.metric, iterate)?.values;
            let pairs = target.iter().zip(&iterate.multiplier);
            let change: Vec<f64> = pairs.map(|(x, l)| x - l).collect();
            condensed.shift(iterate, &change)?;
            iterate.multiplier.copy_from_slice(&target);
        }
    }
}
