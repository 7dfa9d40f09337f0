//! Incompressible rubber whose volume changes between the vertices, where its pressure keeps it in
//! the mean alone: J = det F at the points of the rule, one in the body. Cost: nothing.

use crate::model::Model;
use crate::report::{StepReport, Termination, Warning, WarningKind};

/// 1 - J at a point from which on a word is due: at the corners of bonded blocks cells turn inside
/// out soon after.
const COARSE: f64 = 0.3;

/// A converged body that keeps its volume and has lost too much of it at a point.
pub(crate) fn coarse_volume(model: &Model<'_>, report: &StepReport) -> Option<Warning> {
    let mut laws = model.plan.resolved.materials.iter();
    let keeps = laws.all(|one| {
        one.rubber
            .as_ref()
            .is_some_and(|law| law.inverse_bulk == 0.0)
    });
    let lost = 1.0 - report.min_jacobian.filter(|_| keeps)?;
    let is_converged = report.termination == Termination::Converged;
    (is_converged && lost > COARSE).then(|| {
        let percent = 100.0 * lost;
        Warning::new(
            WarningKind::CoarseVolume,
            "",
            Some(lost),
            format!("the body keeps its volume, and a point of it has lost {percent:.0} %: mesh finer where it is strained most"),
        )
    })
}
