//! Dual solutions of goals at the present state of a run.
//!
//! Cost: one program on a fixed set of contacts a goal, with operators made once.

use super::error::GoalError;
use super::resolved::ResolvedGoal;
use crate::linalg::vector::{dot, norm};
use crate::model::evaluate::Evaluation;
use crate::model::state::State;
use crate::report::Termination;
use crate::scene::Goal;
use crate::sqp::fields::Fields;
use crate::sqp::program::{DualFailure, QuadraticProgram, Wanted};
use crate::sqp::run::Run;

/// True residual over its scale that is enough for bounds: they are roots of products of recovered
/// errors, which no residual of this size moves by as much as a hundredth.
const FOR_BOUNDS: f64 = 1e-4;
/// The same for derivatives, over the tolerance of the state: they are wrong by half of it at most,
/// mostly by some hundredths (a bent cube, Hertz, blocks and a ball of rubber).
const OF_TOLERANCE: f64 = 1e3;
/// Between these in any case, so that derivatives are those of differences to 1e-6.
const FOR_DERIVATIVES: [f64; 2] = [1e-10, 1e-6];

/// What dual solutions are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Bounds of errors.
    Bounds,
    /// Derivatives.
    Derivatives,
}

impl Purpose {
    /// True residual over its scale that a solution may leave.
    fn target(self, run: &Run<'_>) -> f64 {
        match self {
            Self::Bounds => FOR_BOUNDS,
            Self::Derivatives => {
                let [least, most] = FOR_DERIVATIVES;
                (OF_TOLERANCE * run.model.conditions.tolerance).clamp(least, most)
            }
        }
    }
}

/// A goal with its dual solution.
pub(super) struct Dual {
    /// As it was named.
    pub(super) name: Goal,
    /// On the body.
    pub(super) goal: ResolvedGoal,
    /// y, non-dimensional.
    pub(super) fields: Fields,
    /// What of it belongs to the law of friction, where points slip `[multipliers]`; empty without.
    pub(super) law: Vec<f64>,
    /// True residual over its scale.
    pub(super) residual: f64,
    /// Applications of the displacement preconditioner.
    pub(super) applications: u32,
    /// Wall seconds.
    pub(super) seconds: f64,
}

impl Dual {
    /// y . R, where points slip with the law of friction, t = r(l) t / |t|.
    pub(super) fn work(&self, state: &State, now: &Evaluation) -> f64 {
        let y = &self.fields;
        dot(&y.displacement, &now.force)
            + dot(&y.pressure, &now.constraint)
            + dot(&y.multiplier, &now.gap)
            + self.work_of_law(state, now)
    }

    /// y . (r e - t) of the points that slip.
    fn work_of_law(&self, state: &State, now: &Evaluation) -> f64 {
        let Some(law) = now.friction.as_ref().filter(|_| !self.law.is_empty()) else {
            return 0.0;
        };
        let own = law.normals..law.normals + law.tractions();
        let width = law.components.count();
        let [y, tractions] = [&self.law[own.clone()], &state.multiplier[own]];
        let points = y.chunks(width).zip(tractions.chunks(width));
        let points = points.zip(law.radii(&state.multiplier));
        let slipping = points.filter(|((y, _), _)| y.iter().any(|value| *value != 0.0));
        let parts = slipping.map(|((y, t), radius)| (radius / norm(t) - 1.0) * dot(y, t));
        parts.sum()
    }
}

/// The dual solution of one goal.
pub(super) fn dual(
    run: &mut Run<'_>,
    program: &mut QuadraticProgram<'_>,
    (goal, purpose): (&Goal, Purpose),
) -> Result<Dual, GoalError> {
    let start = std::time::Instant::now();
    let resolved = ResolvedGoal::new((&run.model, &*run.state), goal)?;
    let right = resolved.derivative(&run.model, run.state, run.work);
    let before = run.counters.applications;
    let target = purpose.target(run);
    let known = run.learned.duals.of(&goal.to_string());
    let wanted = Wanted {
        right: &right,
        target,
        known: &known,
    };
    let solved = program.solve_dual(run, wanted);
    let solved = solved.map_err(|failure| failed(run, (goal, failure)))?;
    Ok(Dual {
        name: goal.clone(),
        goal: resolved,
        fields: solved.fields,
        law: solved.law,
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
