//! Rubber whose volume changes between the vertices by more than its pressure explains, which keeps
//! it in the mean alone:
//!
//! ```text
//! 1 - J > 0.3 + max |p| / K,   J = det F at the points of the rule
//! ```
//!
//! Bodies without pressure unknowns have J = 1 + p / K at every point. Cost: a pass over pressures.

use crate::linalg::vector::largest;
use crate::model::Model;
use crate::model::state::State;
use crate::report::{StepReport, Termination, Warning, WarningKind};

/// 1 - J at a point from which on a word is due: a bonded square of two cells an edge passes it at
/// 0.4 of its height, of the examples a finger (0.43) and a lip (0.36); cells at the corners of
/// bonded blocks turn inside out soon after.
const COARSE: f64 = 0.3;

/// A converged body that has lost more of its volume at a point than its pressure explains.
pub(crate) fn coarse_volume(
    model: &Model<'_>,
    state: &State,
    report: &StepReport,
) -> Option<Warning> {
    let laws = model.plan.problem.resolved.materials.iter();
    let softest = laws.filter_map(|one| one.rubber.as_ref().map(|law| law.inverse_bulk));
    let softest = softest.fold(0.0, f64::max);
    let explained = largest(&state.pressure) * model.plan.problem.units.stress * softest;
    let is_mixed = !state.pressure.is_empty();
    let lost = 1.0 - report.min_jacobian.filter(|_| is_mixed)?;
    let is_converged = report.termination == Termination::Converged;
    (is_converged && lost > COARSE + explained).then(|| {
        let percent = 100.0 * lost;
        Warning::new(
            WarningKind::CoarseVolume,
            "",
            Some(lost),
            format!("a point of the body has lost {percent:.0} % of its volume, more than its pressure explains: mesh finer where it is strained most"),
        )
    })
}
