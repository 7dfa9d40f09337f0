//! Moves a state to where an increment leads: at once, or in parts where the whole
//! fails. A body that starts inside an obstacle is let in by as much as it is
//! inside, and pushed out over the parts. Equilibria of rubber are certified; one
//! that is no minimum is not kept, and where parts become too small the cause says
//! whether the body is about to snap.

use super::attempt::attempt;
use super::diagnosis::{is_soft, name_the_end};
use super::increment;
use super::initial_penetration::InitialPenetration;
use super::lowest_mode::LowestMode;
use super::penalty::{next_penalty, penalise};
use super::run::{Retry, Run};
use super::step_control::{KeptState, Parts};
use super::trend::Trend;
use crate::model::drive::Drive;
use crate::model::ending::Ending;
use crate::model::state::State;
use crate::report::{Cause, Termination};

/// Smallest part of an increment that cut-backs try.
const LEAST_FRACTION: f64 = 1.0 / 64.0;
/// Smallest part of an increment that looks for the last minimum.
const LEAST_UNSTABLE_FRACTION: f64 = 1.0 / 8.0;
/// Residual below which an iterate that did not converge is kept.
const MEANINGFUL: f64 = 1e-3;

/// Moves the state to `goal`, in parts where the whole fails; returns how it
/// ended and the part reached.
pub(crate) fn approach(run: &mut Run<'_>, goal: &Drive) -> (Ending, f64) {
    let start = run.state.drive.clone();
    let penetration = InitialPenetration::of(&run.model, run.state, &start);
    let mut parts = Parts::new(penetration.first_part());
    loop {
        let next = parts.next();
        run.model.admitted_penetration = penetration.left(next);
        let kept = KeptState::of(run);
        let mut ending = attempt(run, &start.towards(goal, next));
        note_trend(run, &ending, &kept.state);
        match ending.termination {
            Termination::Converged if next >= 1.0 => return (ending, 1.0),
            Termination::Converged => parts.succeed(),
            Termination::NotConverged if cut_backs_help(run, &ending) => {
                kept.restore(run);
                parts.failures += 1;
                run.model.admitted_penetration = penetration.left(parts.reached);
                if let Some(ending) = after_failure(run, ending, &mut parts) {
                    return finished(run, ending, &penetration, &parts);
                }
            }
            // Far from equilibrium an iterate is of no use; close to it, it
            // is the best there is.
            Termination::NotConverged if is_meaningful(&ending) => return (ending, next),
            Termination::NotConverged => {
                kept.restore(run);
                increment::describe(run, &mut ending);
                return (ending, parts.reached);
            }
            Termination::Cancelled | Termination::DeadlineExceeded | Termination::InternalError => {
                kept.restore(run);
                return finished(run, ending, &penetration, &parts);
            }
        }
    }
}

/// Brings a penalty in or makes the next part smaller; how the way ends where
/// neither leads on. The state is the last good one.
fn after_failure(run: &mut Run<'_>, mut ending: Ending, parts: &mut Parts) -> Option<Ending> {
    if let Some(weight) = next_penalty(run, &ending, parts) {
        let settled = penalise(run, weight);
        if settled.is_stopped() {
            return Some(settled);
        }
        if settled.termination == Termination::Converged {
            parts.failures = 0;
            return None;
        }
        parts.tried = weight;
    }
    parts.cut_back();
    run.counters.cut_backs += 1;
    if parts.part >= least_fraction(run, &ending) {
        return None;
    }
    name_the_end(run, &mut ending);
    increment::describe(run, &mut ending);
    Some(ending)
}

/// Whether an iterate that did not converge is still of use.
fn is_meaningful(ending: &Ending) -> bool {
    let is_unbounded = matches!(
        ending.cause,
        Some(Cause::NoEquilibrium | Cause::EnclosedVolume | Cause::NotFinite)
    );
    !is_unbounded && ending.residuals.largest() < MEANINGFUL
}

/// A linear problem that fails as a whole fails in parts too, and so does a
/// nested method that spends its products, and a volume that cannot change. A program of
/// a linear body that a method did not solve is left to the next method.
fn cut_backs_help(run: &Run<'_>, ending: &Ending) -> bool {
    let model = &run.model;
    let is_left = run.retry == Retry::AnotherMethod && !model.is_rubber();
    if is_left && run.counters.failed_programs > 0 {
        return false;
    }
    let is_linear = model.is_linear();
    let is_spent =
        model.plan.contact.method.is_nested() && ending.cause == Some(Cause::IterationLimit);
    let is_hopeless = is_spent || ending.cause == Some(Cause::EnclosedVolume);
    (!is_linear && !is_hopeless) || ending.cause == Some(Cause::ActiveSetCycle)
}

/// The end of a way that leads no further than its last good part; a step that was
/// cancelled keeps none, one whose time is up all that are equilibria.
fn finished(
    run: &Run<'_>,
    mut ending: Ending,
    penetration: &InitialPenetration,
    parts: &Parts,
) -> (Ending, f64) {
    let is_kept = match ending.termination {
        Termination::Converged | Termination::NotConverged => true,
        Termination::DeadlineExceeded => !penetration.takes_parts(),
        Termination::Cancelled | Termination::InternalError => false,
    };
    let mode = run.learned.lowest_mode.as_ref();
    ending.stability = mode.map(LowestMode::stability);
    (ending, if is_kept { parts.reached } else { 0.0 })
}

/// Keeps how rubber moved in a part that converged.
fn note_trend(run: &mut Run<'_>, ending: &Ending, before: &State) {
    if run.model.is_rubber() && ending.termination == Termination::Converged {
        let known = run.learned.trend.take();
        run.learned.trend = Trend::noted(&run.model, known, before, run.state);
    }
}

/// Near the end of stability every part is dear, and none leads far.
fn least_fraction(run: &Run<'_>, ending: &Ending) -> f64 {
    match ending.cause {
        Some(Cause::UnstableEquilibrium) => LEAST_UNSTABLE_FRACTION,
        _ if is_soft(run) => LEAST_UNSTABLE_FRACTION,
        _ => LEAST_FRACTION,
    }
}
