//! Brings a body to rest that no support holds, where solving at once has failed, by a
//! [flow](super::proximal_flow).
//!
//! Near the limit of friction all that resists a motion is a few points that stick, faces on the
//! way to them resist nothing, and programs throw the body away; here each is that of a held body.
//! Where points stick the force of the flow falls by the ratio of t M to their stiffness, a
//! hundredth at first; where nothing resists it stays as it is, however light t becomes, and there
//! is no equilibrium. Where forces are monotone the flow never grows (R. T. Rockafellar, SIAM J. Control
//! Optim. 14, 1976): one that has grown has left an equilibrium that was lost, as of a ring that a fluid
//! pushes out between plates. Where it then comes to no rest, or is farther away than the body is long,
//! there is none. Non-dimensional. Cost: three to ten solves, of scenes that would fail.

use super::increment::{residuals, solve as solve_at_once};
use super::proximal_flow::{Advance, End, Flow, Limits, Policy};
use super::run::Run;
use crate::linalg::vector::largest;
use crate::model::conditions::Conditions;
use crate::model::drive::Drive;
use crate::model::ending::Ending;
use crate::model::state::State;
use crate::report::{Attempt, Cause, Strategy, Termination};

constants! {
    /// First t, in mu / L^2: M holds vertices and edges, rigid motions move vertices alone.
    const FIRST_WEIGHT: f64 = 2e-2;
    /// Steps at most.
    const MOST_STEPS: u32 = 40;
    /// Failures one after the other that end the flow: each makes t heavier, and the first step of a block that
    /// all of friction does not hold takes four.
    const MOST_FAILURES: u32 = 5;
    /// Change of t after a step that was not solved.
    const HEAVIER: f64 = 8.0;
    /// Change of t after a step that hardly changes the force of the flow.
    const LIGHTER: f64 = 0.25;
    /// Residual that a step may leave over that before it, and at most.
    const SHARPNESS: [f64; 2] = [0.01, 1e-3];
    /// Force over that of the step before from which on a lighter t is tried.
    const SLOW: f64 = 0.3;
    /// The same from which on nothing resists.
    const UNRESISTED: f64 = 0.99;
    /// Such steps one after the other that show it.
    const MOST_UNRESISTED: u32 = 8;
    /// Force over the least before from which on the equilibrium is lost, not the motion uneven: 1.75 and 1.97 of
    /// rings that are pushed out, 1.12 of one that came near to rest. Without unit.
    const GROWN: f64 = 1.25;
    /// Motion from where it began, in lengths of the body, beyond which rest would be another place: rings that are
    /// pushed out went 2.3 to 15. Chosen.
    const FAR: f64 = 1.0;
    /// Force over that at the last trial of the end at which the end is tried.
    const EBB: f64 = 0.1;
}

/// Moves the state to equilibrium under `drive`: at once, or by a flow where that fails and
/// nothing but contact holds the body.
pub(super) fn solve(run: &mut Run<'_>, drive: &Drive) -> Ending {
    let start = run.model.plan.is_floating().then(|| run.state.clone());
    let before = run.counters.applications;
    let ending = solve_at_once(run, drive);
    let Some(start) = start.filter(|_| is_for(run, &ending)) else {
        return ending;
    };
    run.counters.attempts.push(Attempt {
        strategy: Strategy::Part,
        cause: ending.cause,
        preconditioner_applications: run.counters.applications - before,
        followed_by: Some(Strategy::ProximalRest),
    });
    let failed = std::mem::replace(run.state, start);
    let flow = Flow::new(run, |_| FIRST_WEIGHT);
    let mut policy = Rest::from(run.state);
    let rest = flow.follow(run, drive, &mut policy);
    let is_settled = rest.termination != Termination::NotConverged;
    if is_settled || rest.cause == Some(Cause::NoEquilibrium) {
        return rest;
    }
    *run.state = failed;
    let is_gone = policy.has_grown || policy.is_far();
    Ending {
        cause: is_gone.then_some(Cause::NoEquilibrium).or(ending.cause),
        ..ending
    }
}

/// Whether an ending may be that of the method alone.
fn is_for(run: &Run<'_>, ending: &Ending) -> bool {
    // What is thrown away leaves all numbers.
    let is_numerical =
        ending.cause == Some(Cause::NotFinite) || ending.cause.is_some_and(Cause::is_numerical);
    is_numerical && (run.model.is_linear() || run.model.plan.has_friction())
}

/// A flow to rest.
struct Rest {
    /// Where it began `[displacement]`.
    start: Vec<f64>,
    /// How far a step has led from there, in lengths of the body.
    moved: f64,
    /// Least force of all steps.
    least: f64,
    /// Whether the force has grown.
    has_grown: bool,
    /// Force out of balance without the proximal term, over the scale of forces: that of the last
    /// step.
    force: f64,
    /// The same when the end was tried last.
    tried: f64,
    /// Steps one after the other that nothing resisted.
    unresisted: u32,
}

impl Rest {
    /// From that state.
    fn from(start: &State) -> Self {
        Self {
            start: start.displacement.clone(),
            moved: 0.0,
            least: f64::INFINITY,
            has_grown: false,
            force: f64::INFINITY,
            tried: f64::INFINITY,
            unresisted: 0,
        }
    }

    /// Notes the force of a step that has led to `state`.
    fn note(&mut self, force: f64, state: &State) {
        self.has_grown |= force > GROWN * self.least;
        self.least = self.least.min(force);
        let ways = state.displacement.iter().zip(&self.start);
        self.moved = ways.fold(self.moved, |most, (a, b)| most.max((a - b).abs()));
    }

    /// Whether rest would be another place.
    fn is_far(&self) -> bool {
        self.moved > FAR
    }
}

impl Policy for Rest {
    const LIMITS: Limits = Limits {
        steps: MOST_STEPS,
        failures: MOST_FAILURES,
        heavier: HEAVIER,
    };

    fn conditions(&mut self, run: &mut Run<'_>) -> Conditions {
        let conditions = run.model.conditions.clone();
        let sharp = (SHARPNESS[0] * self.force).min(SHARPNESS[1]);
        Conditions {
            tolerance: sharp.max(conditions.tolerance),
            ..conditions
        }
    }

    /// What nothing resists is soon farther away than anything could have carried it.
    fn fail(&mut self, _: &Run<'_>, ending: &mut Ending) -> bool {
        let has_flown = ending.cause == Some(Cause::NotFinite) && self.unresisted > 0;
        if has_flown {
            ending.cause = Some(Cause::NoEquilibrium);
        }
        has_flown
    }

    fn advance(&mut self, run: &mut Run<'_>, flow: &mut Flow, _: &State) -> Advance {
        let now = run.evaluate();
        let force = residuals(run.state, &now, 0.0).equilibrium;
        let share = force / std::mem::replace(&mut self.force, force);
        self.note(force, run.state);
        let is_unresisted = share > UNRESISTED && largest(&run.state.displacement) > 0.0;
        self.unresisted = if is_unresisted {
            self.unresisted + 1
        } else {
            0
        };
        if share > SLOW {
            flow.weight *= LIGHTER;
        }
        if self.unresisted == MOST_UNRESISTED || (self.has_grown && self.is_far()) {
            return Advance::Nowhere(Cause::NoEquilibrium);
        }
        if force <= run.model.conditions.tolerance || force <= EBB * self.tried {
            Advance::End
        } else {
            Advance::Step
        }
    }

    fn end(&mut self, run: &mut Run<'_>, _: &mut Flow, drive: &Drive) -> End {
        self.tried = self.force;
        let ending = solve_at_once(run, drive);
        if ending.termination == Termination::NotConverged {
            End::NotYet
        } else {
            End::At(ending.into())
        }
    }
}
