//! Moves a state to where an increment leads: at once, or in parts where the whole
//! fails. A body that starts inside an obstacle is let in by as much as it is
//! inside, and pushed out over the parts. Equilibria of rubber are certified; one
//! that is no minimum is not kept, and where parts become too small the cause says
//! whether the body is about to snap.

use super::Session;
use super::parts::{Good, Parts};
use super::relief::Relief;
use crate::contact::gap::linearise;
use crate::linalg::vector::{add_scaled, dot, norm};
use crate::linalg::{LinearOperator, Workspace};
use crate::report::{Cause, Stability, Termination};
use crate::sqp::counters::Counters;
use crate::sqp::drive::Drive;
use crate::sqp::evaluate::Context;
use crate::sqp::increment::{self, Ending};
use crate::sqp::predictor::Trend;
use crate::sqp::stability::Softest;
use crate::sqp::state::{Snapshot, State};
use crate::sqp::watch::Watch;
use crate::sqp::{accuracy, stability};

/// Smallest part of an increment that cut-backs try.
const LEAST_FRACTION: f64 = 1.0 / 64.0;
/// Smallest part of an increment that looks for the last minimum.
const LEAST_UNSTABLE_FRACTION: f64 = 1.0 / 8.0;
/// Residual below which an iterate that did not converge is kept.
const MEANINGFUL: f64 = 1e-3;
/// Least eigenvalue over that at rest below which a body is about to snap.
const SOFT: f64 = 0.1;
/// Failures of one part after another that bring the volume term in.
const PATIENCE: u32 = 2;
/// First shares of a penalty: what the pair has moved wrongly comes back by degrees.
const GENTLE: [f64; 2] = [0.0625, 0.25];
/// Share of a constant pressure's forces that contact may leave.
const CLOSED: f64 = 1e-6;

/// Whether an iterate that did not converge is still of use.
fn is_meaningful(ending: &Ending) -> bool {
    let is_unbounded = matches!(
        ending.cause,
        Some(Cause::NoEquilibrium | Cause::EnclosedVolume | Cause::NotFinite)
    );
    !is_unbounded && ending.residuals.largest() < MEANINGFUL
}

impl Session {
    /// Moves `state` to `goal`, in parts where the whole fails; returns how it
    /// ended and the part reached.
    pub(super) fn approach(
        &self,
        state: &mut State,
        goal: &Drive,
        watch: &mut Watch<'_>,
        counters: &mut Counters,
        work: &mut Workspace,
    ) -> (Ending, f64) {
        let whole = self.context();
        let start = state.drive.clone();
        let relief = Relief::of(&whole, state, &start);
        let mut parts = Parts::new(relief.first_part());
        loop {
            let next = parts.next();
            let left = relief.left(next);
            let context = Context {
                relief: &left,
                ..whole
            };
            let good = Good::of(state);
            let drive = start.towards(goal, next);
            let mut ending = self.attempt(&context, state, &drive, watch, counters, work);
            note_trend(&context, &ending, &good.fields, state);
            match ending.termination {
                Termination::Converged if next >= 1.0 => return (ending, 1.0),
                Termination::Converged => parts.succeed(),
                Termination::NotConverged if self.cut_backs_help(&ending) => {
                    good.restore(state);
                    parts.failures += 1;
                    let left = relief.left(parts.reached);
                    let context = Context {
                        relief: &left,
                        ..whole
                    };
                    let ended = self
                        .after_failure(&context, state, ending, &mut parts, watch, counters, work);
                    if let Some(ending) = ended {
                        return finished(ending, &relief, &parts, state);
                    }
                }
                // Far from equilibrium an iterate is of no use; close to it, it
                // is the best there is.
                Termination::NotConverged if is_meaningful(&ending) => return (ending, next),
                Termination::NotConverged => {
                    good.restore(state);
                    increment::describe(&whole, state, &mut ending, work);
                    return (ending, parts.reached);
                }
                Termination::Cancelled
                | Termination::DeadlineExceeded
                | Termination::InternalError => {
                    good.restore(state);
                    return finished(ending, &relief, &parts, state);
                }
            }
        }
    }

    /// Brings a penalty in or makes the next part smaller; how the way ends where
    /// neither leads on. `state` is the last good one.
    #[allow(clippy::too_many_arguments)]
    fn after_failure(
        &self,
        context: &Context<'_>,
        state: &mut State,
        mut ending: Ending,
        parts: &mut Parts,
        watch: &mut Watch<'_>,
        counters: &mut Counters,
        work: &mut Workspace,
    ) -> Option<Ending> {
        if let Some(weight) = self.next_penalty(&ending, state, parts) {
            let settled = self.penalise(context, state, weight, watch, counters, work);
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
        counters.cut_backs += 1;
        if parts.part >= least_fraction(&ending, state) {
            return None;
        }
        name_the_end(&mut ending, state);
        increment::describe(&self.context(), state, &mut ending, work);
        Some(ending)
    }

    /// Solves one part and says what kind of equilibrium it led to.
    fn attempt(
        &self,
        context: &Context<'_>,
        state: &mut State,
        drive: &Drive,
        watch: &mut Watch<'_>,
        counters: &mut Counters,
        work: &mut Workspace,
    ) -> Ending {
        let mut ending = accuracy::solve(context, state, drive, watch, counters, work);
        self.explain(&mut ending, state, work);
        self.centre_pressure(state);
        certify(context, &mut ending, state, watch, counters, work);
        ending
    }

    /// The weight of the volume penalty where less of it may be what loses the
    /// equilibrium.
    fn next_penalty(&self, ending: &Ending, state: &State, parts: &Parts) -> Option<f64> {
        let is_lost = ending.cause == Some(Cause::UnstableEquilibrium)
            || is_soft(state)
            || parts.failures >= PATIENCE;
        let pressures = state.pressure.iter();
        let largest = pressures.fold(0.0, |most: f64, p| most.max(p.abs()));
        let present = state.penalty().max(parts.tried);
        let weight = self.plan.next_penalty(present, largest);
        weight.filter(|_| is_lost)
    }

    /// Moves a good state to where a larger penalty has its equilibrium; leaves it
    /// as it was where that is not found.
    fn penalise(
        &self,
        context: &Context<'_>,
        state: &mut State,
        weight: f64,
        watch: &mut Watch<'_>,
        counters: &mut Counters,
        work: &mut Workspace,
    ) -> Ending {
        let good = Good::of(state);
        let drive = state.drive.clone();
        let mut shares = GENTLE.into_iter();
        loop {
            let share = shares.next().unwrap_or(1.0);
            state.penalise(&self.prepared, share * weight);
            state.upkeep.renew();
            let ending = self.attempt(context, state, &drive, watch, counters, work);
            if ending.termination != Termination::Converged {
                good.restore(state);
                return ending;
            }
            if share >= 1.0 {
                return ending;
            }
        }
    }

    /// Names what the Krylov method could only notice as stagnation.
    fn explain(&self, ending: &mut Ending, state: &State, work: &mut Workspace) {
        let stuck = matches!(
            ending.cause,
            Some(Cause::Stagnation | Cause::IterationLimit | Cause::LineSearch)
        );
        let touches = state.active.iter().any(|&active| active);
        let is_enclosed = self
            .prepared
            .pressure
            .as_ref()
            .is_some_and(|p| p.is_enclosed);
        if stuck && self.plan.is_floating() && !touches {
            ending.cause = Some(Cause::NoEquilibrium);
        } else if stuck && (is_enclosed || self.is_closed_by_contact(&state.drive, work)) {
            ending.cause = Some(Cause::EnclosedVolume);
        }
    }

    /// Whether contact everywhere would hold a constant pressure at rest: obstacles
    /// then fix a volume which the material fixes too.
    fn is_closed_by_contact(&self, drive: &Drive, work: &mut Workspace) -> bool {
        let context = self.context();
        let fixed = self.prepared.pressure.as_ref();
        let Some(block) = fixed.filter(|block| block.stabilisation.is_none()) else {
            return false;
        };
        let size = block.coupling.size;
        let (mut pushed, mut held) = (vec![0.0; size], vec![0.0; size]);
        let ones = vec![1.0; block.coupling.vertices];
        block.coupling.apply_transposed(&ones, &mut pushed, work);
        let rest = vec![0.0; size];
        let body = context.deformed(&rest);
        let obstacles = self.interfaces.obstacles(drive, self.plan.units.length);
        for (interface, obstacle) in self.interfaces.list.iter().zip(&obstacles) {
            let is_held = &self.prepared.is_held;
            let part = linearise(&body, &interface.surface, obstacle, is_held);
            for (index, value) in part.rows.into_iter().flatten() {
                held[index as usize] += value;
            }
        }
        let before = norm(&pushed);
        let share = dot(&pushed, &held) / dot(&held, &held).max(f64::MIN_POSITIVE);
        add_scaled(&mut pushed, -share, &held);
        before > 0.0 && norm(&pushed) <= CLOSED * before
    }

    /// An enclosed incompressible body fixes its pressure up to a constant:
    /// the mean is set to zero.
    fn centre_pressure(&self, state: &mut State) {
        let Some(block) = self
            .prepared
            .pressure
            .as_ref()
            .filter(|block| block.is_enclosed)
        else {
            return;
        };
        let mut weights = vec![0.0; state.pressure.len()];
        let ones = vec![1.0; weights.len()];
        block
            .metric
            .mass()
            .apply(&ones, &mut weights, &mut Workspace::new());
        let mean = dot(&weights, &state.pressure) / weights.iter().sum::<f64>();
        state.pressure.iter_mut().for_each(|p| *p -= mean);
    }

    /// A linear problem that fails as a whole fails in parts too, and so does a
    /// nested method that spends its products, and a volume that cannot change.
    fn cut_backs_help(&self, ending: &Ending) -> bool {
        let is_linear = self.context().is_linear();
        let is_spent =
            self.plan.contact.method.is_nested() && ending.cause == Some(Cause::IterationLimit);
        let is_hopeless = is_spent || ending.cause == Some(Cause::EnclosedVolume);
        (!is_linear && !is_hopeless) || ending.cause == Some(Cause::ActiveSetCycle)
    }
}

/// The end of a way that leads no further than its last good part; a step that was
/// cancelled keeps none, one whose time is up all that are equilibria.
fn finished(mut ending: Ending, relief: &Relief, parts: &Parts, state: &State) -> (Ending, f64) {
    let is_kept = match ending.termination {
        Termination::Converged | Termination::NotConverged => true,
        Termination::DeadlineExceeded => relief.penetration.is_empty(),
        Termination::Cancelled | Termination::InternalError => false,
    };
    ending.stability = state.softest.as_ref().map(Softest::stability);
    (ending, if is_kept { parts.reached } else { 0.0 })
}

/// Looks whether a converged state of rubber is a minimum; a saddle is no end.
fn certify(
    context: &Context<'_>,
    ending: &mut Ending,
    state: &mut State,
    watch: &Watch<'_>,
    counters: &mut Counters,
    work: &mut Workspace,
) {
    if ending.termination != Termination::Converged {
        return;
    }
    state.softest = stability::follow(context, state, watch, counters, work);
    let is_unknown = state.softest.is_none() && context.prepared.strain.is_some();
    if let Some(termination) = watch.stopped(counters).filter(|_| is_unknown) {
        ending.termination = termination;
        return;
    }
    ending.stability = state.softest.as_ref().map(|softest| softest.stability());
    if ending.stability == Some(Stability::Saddle) {
        ending.termination = Termination::NotConverged;
        ending.cause = Some(Cause::UnstableEquilibrium);
    }
}

/// Keeps how rubber moved in a part that converged.
fn note_trend(context: &Context<'_>, ending: &Ending, before: &Snapshot, state: &mut State) {
    let is_rubber = context.prepared.strain.is_some();
    if is_rubber && ending.termination == Termination::Converged {
        let known = state.trend.take();
        state.trend = Trend::noted(context, known, before, state);
    }
}

/// Near the end of stability every part is dear, and none leads far.
fn least_fraction(ending: &Ending, state: &State) -> f64 {
    match ending.cause {
        Some(Cause::UnstableEquilibrium) => LEAST_UNSTABLE_FRACTION,
        _ if is_soft(state) => LEAST_UNSTABLE_FRACTION,
        _ => LEAST_FRACTION,
    }
}

fn is_soft(state: &State) -> bool {
    let softest = state.softest.as_ref();
    softest.is_some_and(|softest| softest.eigenvalue < SOFT)
}

/// The cause of an increment whose parts became too small: a body that has grown
/// soft meets a limit of its load.
fn name_the_end(ending: &mut Ending, state: &State) {
    ending.cause = match ending.cause {
        Some(
            Cause::Stagnation
            | Cause::IterationLimit
            | Cause::LineSearch
            | Cause::IndefiniteTangent
            | Cause::NegativeJacobian,
        )
        | None
            if is_soft(state) =>
        {
            Some(Cause::LimitPoint)
        }
        None => Some(Cause::StepTooSmall),
        named => named,
    };
}
