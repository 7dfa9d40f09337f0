//! Moves a state to where an increment leads: at once, or in parts where the whole
//! fails. A body that starts inside an obstacle is let in by as much as it is
//! inside, and pushed out over the parts. Equilibria of rubber are certified; one
//! that is no minimum is not kept. Where parts become too small the body falls to the next
//! minimum ([`super::descent`]), or the cause says whether it is about to.

use super::attempt::attempt;
use super::descent::descend;
use super::diagnosis::{is_soft, name_the_end, name_the_impossible};
use super::increment;
use super::initial_penetration::InitialPenetration;
use super::lowest_mode::LowestMode;
use super::passing::{MOST_PARTS, longest_part};
use super::penalty::{next_penalty, penalise};
use super::run::Run;
use super::step_control::{KeptState, Parts};
use super::trend::Trend;
use crate::model::conditions::Conditions;
use crate::model::drive::Drive;
use crate::model::ending::{Ending, Snap};
use crate::model::state::State;
use crate::report::{Cause, Termination};

/// Smallest part of an increment that cut-backs try, and of the longest part where tools bound
/// it to less: what fails there fails anew behind each small part.
const LEAST_FRACTION: f64 = 1.0 / 64.0;
const LEAST_BOUNDED_FRACTION: f64 = 1.0 / 4.0;
/// Smallest part of the longest one that looks for the last minimum.
const LEAST_UNSTABLE_FRACTION: f64 = 1.0 / 8.0;
/// The same of a body that may fall, and how far the first fall leads: what a smaller part
/// would find is on the way down.
const FALLING_FRACTION: f64 = 1.0 / 2.0;
/// Residual below which an iterate that did not converge is kept.
const MEANINGFUL: f64 = 1e-3;

/// The way to a goal.
struct Way<'w> {
    /// What drove the body at the start.
    start: Drive,
    /// What shall drive it at the end.
    goal: &'w Drive,
    /// By how much the start lies inside obstacles.
    penetration: InitialPenetration,
    /// Parts of the way.
    parts: Parts,
    /// Fraction of the way to which tools do not bound a part.
    least_bound: f64,
    /// All falls on the way.
    snapped: Option<Snap>,
    /// How far a fall leads: half as far behind each that has found no minimum.
    falling: f64,
}

/// Moves the state to `goal`, in parts where the whole fails; returns how it
/// ended and the part reached.
pub(crate) fn approach(run: &mut Run<'_>, goal: &Drive) -> (Ending, f64) {
    let start = run.state.drive.clone();
    let goal = &goal.carried_by(&start);
    let penetration = InitialPenetration::of(&run.model, run.state, &start);
    let longest = longest_part(&run.model, run.state, goal);
    let mut way = Way {
        start,
        goal,
        parts: Parts::new(longest),
        least_bound: (1.0 - longest) / MOST_PARTS,
        penetration,
        snapped: None,
        falling: first_fall(run.state),
    };
    let (mut ending, part) = way.walk(run);
    if ending.termination == Termination::Converged {
        run.learned.converged.add(run.counters.applications);
    }
    name_the_impossible(run, &mut ending, goal);
    ending.snapped = way.snapped;
    (ending, part)
}

impl Way<'_> {
    /// Part after part to the end; how it ended and the part reached.
    fn walk(&mut self, run: &mut Run<'_>) -> (Ending, f64) {
        loop {
            // Nothing polls where a part needs no iteration.
            if let Some(termination) = run.stopped() {
                let ending = increment::stopped(run, termination);
                return finished(run, ending, &self.penetration, &self.parts);
            }
            let next = self.parts.next();
            let kept = KeptState::of(run);
            let drive = self.start.towards(self.goal, next);
            let mut ending = attempt(&mut run.under(self.conditions(run, next)), &drive);
            note_trend(run, &ending, &kept.state);
            match ending.termination {
                Termination::Converged if next >= 1.0 => return (ending, 1.0),
                Termination::Converged => {
                    self.parts.succeed();
                    self.bound(run);
                }
                Termination::NotConverged if cut_backs_help(run, &ending) && !run.is_spent() => {
                    let is_saddle = ending.cause == Some(Cause::UnstableEquilibrium);
                    let lost = run.learned.lowest_mode.clone().filter(|_| is_saddle);
                    kept.restore(run);
                    self.parts.failures += 1;
                    let run = &mut run.under(self.conditions(run, self.parts.reached));
                    if let Some(ending) = self.after_failure(run, ending, lost.as_ref()) {
                        return finished(run, ending, &self.penetration, &self.parts);
                    }
                }
                // Far from equilibrium an iterate is of no use; close to it, it
                // is the best there is.
                Termination::NotConverged if is_meaningful(&ending) => return (ending, next),
                Termination::NotConverged => {
                    kept.restore(run);
                    increment::describe(run, &mut ending);
                    return (ending, self.parts.reached);
                }
                Termination::Cancelled
                | Termination::DeadlineExceeded
                | Termination::InternalError => {
                    kept.restore(run);
                    return finished(run, ending, &self.penetration, &self.parts);
                }
            }
        }
    }

    /// Those of a part that ends at `next`: as deep inside obstacles as the body may be there.
    fn conditions(&self, run: &Run<'_>, next: f64) -> Conditions {
        Conditions {
            admitted_penetration: [self.parts.reached, next].map(|end| self.penetration.left(end)),
            ..run.model.conditions.clone()
        }
    }

    /// Bounds the next part by what tools may advance from here.
    fn bound(&mut self, run: &Run<'_>) {
        let share = longest_part(&run.model, run.state, self.goal);
        let longest = match share < 1.0 {
            true => ((1.0 - self.parts.reached) * share).max(self.least_bound),
            false => 1.0,
        };
        self.parts.bound(longest);
    }

    /// Brings a penalty in, makes the next part smaller or lets the body fall; how the way
    /// ends where nothing leads on. The state is the last good one.
    fn after_failure(
        &mut self,
        run: &mut Run<'_>,
        mut ending: Ending,
        lost: Option<&LowestMode>,
    ) -> Option<Ending> {
        let falls = run.model.plan.falls();
        if !falls && let Some(settled) = self.held_by_penalty(run, (&ending, lost)) {
            return settled.is_stopped().then_some(settled);
        }
        self.parts.cut_back();
        run.counters.cut_backs += 1;
        if self.parts.part >= self.least_fraction(run, &ending) {
            return None;
        }
        // A bold part may come out on a saddle that is not on the way.
        if falls && let Some(settled) = self.held_by_penalty(run, (&ending, lost)) {
            return settled.is_stopped().then_some(settled);
        }
        if self.may_fall(run, &ending) {
            if let Some(settled) = self.fall(run, &ending) {
                let has_landed = settled.termination == Termination::Converged;
                return (!has_landed || self.parts.reached >= 1.0).then_some(settled);
            }
            self.falling *= 0.5;
            if self.parts.part >= self.least_fraction(run, &ending) {
                return None;
            }
        }
        name_the_end(run, &mut ending);
        increment::describe(run, &mut ending);
        Some(ending)
    }

    /// Brings a penalty in where that keeps an equilibrium; how that ended, none where it does
    /// not, and the state as it was.
    fn held_by_penalty(
        &mut self,
        run: &mut Run<'_>,
        failure: (&Ending, Option<&LowestMode>),
    ) -> Option<Ending> {
        let weight = next_penalty(run, failure, &self.parts)?;
        let settled = penalise(run, weight);
        let is_held = settled.termination == Termination::Converged;
        match is_held {
            true => self.parts.failures = 0,
            false => self.parts.tried = weight,
        }
        (is_held || settled.is_stopped()).then_some(settled)
    }

    /// Smallest part that is tried behind a failure. Near the end of stability every part is
    /// dear, and none leads far.
    fn least_fraction(&self, run: &Run<'_>, ending: &Ending) -> f64 {
        let longest = self.parts.longest;
        match is_unstable(run, ending) {
            true if self.may_fall(run, ending) => self.falling * longest,
            true => LEAST_UNSTABLE_FRACTION * longest,
            false => LEAST_FRACTION.min(LEAST_BOUNDED_FRACTION * longest),
        }
    }

    /// Whether the body may fall, and has not done so in vain too often.
    fn may_fall(&self, run: &Run<'_>, ending: &Ending) -> bool {
        self.falling >= LEAST_UNSTABLE_FRACTION && may_fall(run, ending)
    }

    /// Lets the body fall behind a `failure` to the next minimum a part of the way on; none,
    /// and the state as it was, where none is found.
    fn fall(&mut self, run: &mut Run<'_>, failure: &Ending) -> Option<Ending> {
        let was_lost = is_unstable(run, failure);
        let kept = KeptState::of(run);
        let next = self.parts.after(self.falling * self.parts.longest);
        let drive = self.start.towards(self.goal, next);
        let settled = descend(&mut run.under(self.conditions(run, next)), &drive);
        let has_landed = settled
            .as_ref()
            .is_some_and(|ending| ending.termination == Termination::Converged);
        if has_landed {
            self.parts.land(next);
            self.bound(run);
            let fall = settled.as_ref().and_then(|ending| ending.snapped);
            let fall = fall.map(|fall| Snap { was_lost, ..fall });
            self.snapped = match (self.snapped, fall) {
                (Some(before), Some(fall)) => Some(before.and(fall)),
                (before, fall) => before.or(fall),
            };
        } else {
            kept.restore(run);
        }
        settled
    }
}

/// How far the first fall leads. A body at rest leans to no side yet: small parts bend it
/// first, so that it falls as it would under a slow press.
fn first_fall(state: &State) -> f64 {
    match state.displacement.iter().all(|&u| u == 0.0) {
        true => LEAST_UNSTABLE_FRACTION,
        false => FALLING_FRACTION,
    }
}

/// Whether the scene lets a body fall, and the failure is one of an equilibrium lost.
fn may_fall(run: &Run<'_>, ending: &Ending) -> bool {
    let is_elsewhere = matches!(
        ending.cause,
        Some(Cause::NoEquilibrium | Cause::EnclosedVolume | Cause::NotFinite | Cause::InsideOut)
    );
    let is_lost = is_unstable(run, ending)
        || run.learned.lowest_mode.is_none()
        || ending.cause == Some(Cause::ActiveSetCycle);
    run.model.is_rubber() && is_lost && !is_elsewhere && run.model.plan.may_fall()
}

/// Whether an equilibrium was seen to be unstable, or nearly so.
fn is_unstable(run: &Run<'_>, ending: &Ending) -> bool {
    ending.cause == Some(Cause::UnstableEquilibrium) || is_soft(run)
}

/// Whether an iterate that did not converge is still of use.
fn is_meaningful(ending: &Ending) -> bool {
    let is_unbounded = matches!(
        ending.cause,
        Some(Cause::NoEquilibrium | Cause::EnclosedVolume | Cause::NotFinite)
    );
    !is_unbounded && !is_unmet(ending) && ending.residuals.largest() < MEANINGFUL
}

/// A linear problem that fails as a whole fails in parts too, and so does a nested method that
/// spends its products, and a volume that cannot change: what parts of it lead to is a body that
/// escapes between its nodes.
fn cut_backs_help(run: &Run<'_>, ending: &Ending) -> bool {
    let model = &run.model;
    // The way matters where something slips.
    let is_linear = model.is_linear() && !model.plan.has_friction();
    let is_spent =
        model.plan.contact.method.is_nested() && ending.cause == Some(Cause::IterationLimit);
    let is_hopeless = is_spent || ending.cause == Some(Cause::EnclosedVolume) || is_unmet(ending);
    (!is_linear && !is_hopeless) || ending.cause == Some(Cause::ActiveSetCycle)
}

/// Whether an obstacle does not exert what it shall.
fn is_unmet(ending: &Ending) -> bool {
    let site = ending.site.as_ref();
    site.is_some_and(|site| site.unbalanced.is_some())
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
        Termination::DeadlineExceeded => !penetration.is_any(),
        Termination::Cancelled | Termination::InternalError => false,
    };
    let mode = run.learned.lowest_mode.as_ref();
    ending.stability = mode.map(|mode| mode.stability);
    (ending, if is_kept { parts.reached } else { 0.0 })
}

/// Keeps how rubber moved in a part that converged.
fn note_trend(run: &mut Run<'_>, ending: &Ending, before: &State) {
    if run.model.is_rubber() && ending.termination == Termination::Converged {
        let known = run.learned.trend.take();
        run.learned.trend = Trend::noted(&run.model, known, before, run.state);
    }
}
