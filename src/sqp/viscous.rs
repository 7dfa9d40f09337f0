//! Brings a body to rest that no support holds, where solving at once has failed: as one with a
//! little viscosity comes to rest,
//!
//! ```text
//! f(u_k+1) = t_k M (u_k+1 - u_k),   t_k M ~ what the approximate inverse has for rigid motions
//! ```
//!
//! f the forces out of balance ([`crate::model::proximal`]). Near the limit of friction all that
//! resists a motion is a few points that stick, faces on the way to them resist nothing, and
//! programs throw the body away; here each is that of a held body. Where points stick the pull
//! falls by the ratio of t M to their stiffness, a hundredth at first; where nothing resists it
//! stays as it is, however light it becomes, and there is no equilibrium. Non-dimensional. Cost:
//! three to ten solves, of scenes that would fail.

use std::sync::Arc;

use super::increment::{residuals, solve as solve_at_once};
use super::run::Run;
use crate::linalg::vector::largest;
use crate::model::conditions::Conditions;
use crate::model::drive::Drive;
use crate::model::ending::Ending;
use crate::model::proximal::{Proximal, mass};
use crate::report::{Cause, Termination};

/// First t, in mu / L^2: M holds vertices and edges, rigid motions move vertices alone.
const FIRST_WEIGHT: f64 = 2e-2;
/// Steps at most.
const MOST_STEPS: u32 = 40;
/// Failures one after the other that end the way.
const MOST_FAILURES: u32 = 3;
/// Change of the weight behind a step that hardly changes the pull, and one that was not solved.
const CHANGE: [f64; 2] = [0.25, 8.0];
/// Residual that a step may leave over that before it, and at most.
const SHARPNESS: [f64; 2] = [0.01, 1e-3];
/// Pull over the one before from which on a lighter one is tried.
const SLOW: f64 = 0.3;
/// The same from which on nothing resists, and such steps one after the other that show it.
const UNRESISTED: f64 = 0.99;
const MOST_UNRESISTED: u32 = 8;
/// Pull over that behind which the end was tried before at which it is tried.
const EBB: f64 = 0.1;

/// Moves the state to equilibrium under `drive`: at once, or slowly where that fails and
/// nothing but contact holds the body.
pub(super) fn solve(run: &mut Run<'_>, drive: &Drive) -> Ending {
    let start = run.model.plan.is_floating().then(|| run.state.clone());
    let ending = solve_at_once(run, drive);
    let Some(start) = start.filter(|_| is_for(run, &ending)) else {
        return ending;
    };
    let failed = std::mem::replace(run.state, start);
    slowly(run, drive).unwrap_or_else(|| {
        *run.state = failed;
        ending
    })
}

/// Whether an ending may be that of the method alone.
fn is_for(run: &Run<'_>, ending: &Ending) -> bool {
    // What is thrown away leaves all numbers.
    let is_numerical =
        ending.cause == Some(Cause::NotFinite) || ending.cause.is_some_and(Cause::is_numerical);
    // A fall has no place for the pull.
    let has_place = run.model.conditions.proximal.is_none();
    is_numerical && has_place && (run.model.is_linear() || run.model.plan.has_friction())
}

/// Steps to rest; none, where they do not lead there, with a state of no use.
fn slowly(run: &mut Run<'_>, drive: &Drive) -> Option<Ending> {
    Flow::new(run).go(run, drive)
}

/// A way to rest.
struct Flow {
    /// M `[displacement]`.
    mass: Arc<[f64]>,
    /// t.
    weight: f64,
    /// Force out of balance without the pull, over the scale of forces: that of the last step.
    pull: f64,
    /// The same behind which the end was tried.
    tried: f64,
    /// Failures one after the other.
    failures: u32,
    /// Steps one after the other that nothing resisted.
    unresisted: u32,
}

impl Flow {
    fn new(run: &Run<'_>) -> Self {
        Self {
            mass: mass(&run.model).into(),
            weight: FIRST_WEIGHT,
            pull: f64::INFINITY,
            tried: f64::INFINITY,
            failures: 0,
            unresisted: 0,
        }
    }

    /// Step after step until the body rests or nothing holds it.
    fn go(mut self, run: &mut Run<'_>, drive: &Drive) -> Option<Ending> {
        for _ in 0..MOST_STEPS {
            let kept = run.state.clone();
            let mut ending = self.step(run, drive);
            if ending.is_stopped() {
                return Some(ending);
            }
            // What nothing resists is soon farther away than anything could have carried it.
            let has_flown = ending.cause == Some(Cause::NotFinite) && self.unresisted > 0;
            if has_flown {
                ending.cause = Some(Cause::NoEquilibrium);
                return Some(ending);
            }
            if ending.termination != Termination::Converged {
                *run.state = kept;
                self.failures += 1;
                self.weight *= CHANGE[1];
                if self.failures == MOST_FAILURES {
                    return None;
                }
                continue;
            }
            self.advance(run);
            if self.unresisted == MOST_UNRESISTED {
                (ending.termination, ending.cause) =
                    (Termination::NotConverged, Some(Cause::NoEquilibrium));
                return Some(ending);
            }
            let tolerance = run.model.conditions.tolerance;
            let may_end = self.pull <= tolerance || self.pull <= EBB * self.tried;
            let ended = may_end.then(|| self.end(run, drive));
            if let Some(ending) = ended.flatten() {
                return Some(ending);
            }
        }
        None
    }

    /// One step.
    fn step(&self, run: &mut Run<'_>, drive: &Drive) -> Ending {
        let proximal = Proximal {
            weight: self.weight,
            anchor: run.state.displacement.clone().into(),
            mass: self.mass.clone(),
        };
        let sharp = (SHARPNESS[0] * self.pull).min(SHARPNESS[1]);
        let conditions = run.model.conditions.clone();
        let conditions = Conditions {
            proximal: Some(proximal),
            tolerance: sharp.max(conditions.tolerance),
            ..conditions
        };
        solve_at_once(&mut run.under(conditions), drive)
    }

    /// Notes how far a step has led, and chooses the next weight.
    fn advance(&mut self, run: &mut Run<'_>) {
        let now = run.evaluate();
        let pull = residuals(run.state, &now, 0.0).equilibrium;
        let share = pull / std::mem::replace(&mut self.pull, pull);
        self.failures = 0;
        self.unresisted = match share > UNRESISTED && largest(&run.state.displacement) > 0.0 {
            true => self.unresisted + 1,
            false => 0,
        };
        if share > SLOW {
            self.weight *= CHANGE[0];
        }
    }

    /// The equilibrium without the pull; none, and the state as it was, where it is not found.
    fn end(&mut self, run: &mut Run<'_>, drive: &Drive) -> Option<Ending> {
        self.tried = self.pull;
        let kept = run.state.clone();
        let ending = solve_at_once(run, drive);
        let is_end = ending.is_stopped() || ending.termination == Termination::Converged;
        if !is_end {
            *run.state = kept;
        }
        is_end.then_some(ending)
    }
}
