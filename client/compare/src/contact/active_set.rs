//! Primal-dual active set, a semismooth Newton method:
//!
//! ```text
//! next set = { i : D_i l_i > gap_i },   D the diagonal of the metric,   l >= 0,
//! ```
//!
//! each set solved to the end by the saddle solver of `OneLevel`.
//! Hintermueller, Ito and Kunisch, SIAM J. Optim. 13, 2002. The sets shrink by
//! layers of vertices, so that their number grows with refinement. A set that
//! returns ends the solve as a cycle.

use signorini::inequality::blocks::ContactBlock;
use signorini::inequality::dense_cone::DenseSolution;
use signorini::inequality::one_level::FaceRule;
use signorini::inequality::{
    BlockIterate, InequalitySolver, OneLevel, QpIterate, QpOutcome, QpProblem, QpRun, QpStatus,
};
use signorini::saddle::Status;

/// The method on a problem.
pub(crate) struct ActiveSet<'a>(OneLevel<'a>);

impl<'a> ActiveSet<'a> {
    /// The method of this module on `problem`, in its metric.
    pub(crate) fn new(problem: QpProblem<'a>) -> Self {
        let rule = &PrimalDual;
        Self(OneLevel { problem, rule })
    }
}

impl InequalitySolver for ActiveSet<'_> {
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome {
        self.0.solve(iterate, run)
    }
}

/// Where pressure over the metric's diagonal outweighs the gap.
struct PrimalDual;

impl FaceRule for PrimalDual {
    fn next(
        &self,
        block: &ContactBlock<'_>,
        contact: &BlockIterate,
    ) -> Result<DenseSolution, QpStatus> {
        // Closed where D_i (l_i - its least value) > gap_i.
        let least = block.set.lower_bounds().ok_or(QpStatus::Unsupported)?;
        let pairs = contact.multiplier.iter().zip(&least).zip(&contact.residual);
        let closed = pairs
            .enumerate()
            .map(|(i, ((l, least), gap))| block.matrix.entry(i, i) * (l - least) > *gap);
        Ok(DenseSolution {
            status: closed.map(Status::of_contact).collect(),
            values: vec![0.0; least.len()],
            ..DenseSolution::default()
        })
    }

    fn solves_to_the_end(&self) -> bool {
        true
    }
}
