//! Projected Arrow-Hurwicz: fixed steps of the multiplier, projected in its
//! metric H,
//!
//! ```text
//! l <- argmin { 1/2 |x - l|_H^2 + gap(l).x : x in the set },
//! ```
//!
//! displacement and equality unknowns brought to balance after each. The metric
//! is scaled so that H >= K about, which makes the step contract, by about
//! 1 - 1 / cond(H^-1 K). Steps half as long again diverge in the compliance.
//! In the mass the condition grows like 1/h, in the
//! compliance it does not. One product a step and one small dense problem.
//! Arrow, Hurwicz and Uzawa, Studies in Linear and Nonlinear Programming, 1958.

use signorini::inequality::condensed::Condensed;
use signorini::inequality::metric::nearest;
use signorini::inequality::{InequalitySolver, QpIterate, QpOutcome, QpProblem, QpRun};
use signorini::linalg::vector::add_scaled;

/// Products per problem. In the mass they do not suffice for six digits on more
/// than some tens of candidates; the outcome then says so.
const MOST_PRODUCTS: u32 = 400;

/// The method on a problem.
pub(crate) struct ProjectedArrowHurwicz<'a> {
    /// The quadratic program; its contact block has a metric that scales the
    /// multiplier's step.
    pub(crate) problem: QpProblem<'a>,
}

impl InequalitySolver for ProjectedArrowHurwicz<'_> {
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome {
        Condensed::solve(
            &self.problem,
            run,
            MOST_PRODUCTS,
            iterate,
            |iterate, condensed| {
                let (block, place) = (condensed.contact(), condensed.place());
                let contact = &iterate.blocks[place];
                let target = nearest(block.matrix, block.set, contact)?.values;
                let mut change = target.clone();
                add_scaled(&mut change, -1.0, &contact.multiplier);
                condensed.shift(iterate, &change)?;
                iterate.blocks[place].multiplier.copy_from_slice(&target);
                Ok(())
            },
        )
    }
}
