//! Dual solutions of goals at the present state of a run.
//!
//! Cost: one program on a fixed set of contacts a goal, with operators made once.

use super::error::GoalError;
use super::resolved::ResolvedGoal;
use crate::linalg::vector::dot;
use crate::model::evaluate::Evaluation;
use crate::report::Termination;
use crate::scene::Goal;
use crate::sqp::program::{DualFailure, Fields, QuadraticProgram};
use crate::sqp::run::Run;

/// A goal with its dual solution.
pub(super) struct Dual {
    /// As it was named.
    pub(super) name: Goal,
    /// On the body.
    pub(super) goal: ResolvedGoal,
    /// y, non-dimensional.
    pub(super) fields: Fields,
    /// True residual over its scale.
    pub(super) residual: f64,
    /// Applications of the displacement preconditioner.
    pub(super) applications: u32,
    /// Wall seconds.
    pub(super) seconds: f64,
}

/// y . R.
pub(super) fn work(y: &Fields, now: &Evaluation) -> f64 {
    dot(&y.displacement, &now.force)
        + dot(&y.pressure, &now.constraint)
        + dot(&y.multiplier, &now.gap)
}

/// The dual solution of one goal.
pub(super) fn dual(
    run: &mut Run<'_>,
    program: &mut QuadraticProgram<'_>,
    goal: &Goal,
) -> Result<Dual, GoalError> {
    let start = std::time::Instant::now();
    let resolved = ResolvedGoal::new(&run.model, goal)?;
    let right = resolved.derivative(&run.model, run.state, run.work);
    let before = run.counters.applications;
    let solved = program.solve_dual(run, &right);
    let solved = solved.map_err(|failure| failed(run, (goal, failure)))?;
    Ok(Dual {
        name: goal.clone(),
        goal: resolved,
        fields: solved.fields,
        residual: solved.residual,
        applications: run.counters.applications - before,
        seconds: start.elapsed().as_secs_f64(),
    })
}

fn failed(run: &Run<'_>, (goal, failure): (&Goal, DualFailure)) -> GoalError {
    match failure {
        DualFailure::Stopped => GoalError::Stopped(run.stopped().unwrap_or(Termination::Cancelled)),
        DualFailure::Residual(residual) => GoalError::NotSolved {
            goal: goal.to_string(),
            residual,
        },
    }
}
