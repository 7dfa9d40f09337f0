//! Primal-dual active set, a semismooth Newton method:
//!
//! ```text
//! next set = { i : D_i l_i > gap_i },   D the diagonal of the metric,
//! ```
//!
//! each set solved to the end by the saddle solver of [`super::one_level`].
//! Hintermueller, Ito and Kunisch, SIAM J. Optim. 13, 2002. The sets shrink by
//! layers of vertices, so that their number grows with refinement. A set that
//! returns ends the solve as a cycle.

use super::one_level::{OneLevel, SetRule};
use super::{InequalitySolver, QpIterate, QpOutcome, QpProblem, QpRun};

/// The method on a problem.
pub struct ActiveSet<'a>(OneLevel<'a>);

impl<'a> ActiveSet<'a> {
    /// The method of this module on `problem`, in its metric.
    pub fn new(problem: QpProblem<'a>) -> Self {
        let rule = SetRule::PrimalDual;
        Self(OneLevel { problem, rule })
    }
}

impl InequalitySolver for ActiveSet<'_> {
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome {
        self.0.solve(iterate, run)
    }
}
