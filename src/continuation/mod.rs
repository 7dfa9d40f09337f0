//! The load path of an increment: moves a state to where it leads, at once, or in parts where the
//! whole fails. What follows a failure is decided in one place ([`strategy`]).
//!
//! | file | part |
//! |---|---|
//! | [`strategy`] | what follows a failed part |
//! | [`part`] | one part, solved and judged |
//! | [`parts`], [`checkpoint`] | parts of the path, and the equilibrium to go back to |
//! | [`longest_part`], [`initial_penetration`] | how long parts may be, what they admit |
//! | [`fluid_front`], [`seal_trend`], [`leak_bracket`] | fluids on the way, how far they rise at once, and where one leaks |
//! | [`penalty`], [`snap_through`] | strategies beside smaller parts |
//!
//! A body that starts inside an obstacle is let in by as much as it is inside, and pushed out over
//! the parts. Equilibria of rubber are certified; one that is no minimum is not kept. Cost: that of
//! the parts; each failed one is in the report ([`crate::report::Attempt`]).

mod checkpoint;
mod fluid_front;
mod initial_penetration;
mod leak_bracket;
mod longest_part;
mod part;
mod parts;
mod penalty;
mod seal_trend;
mod snap_through;
mod strategy;

use crate::diagnosis::{is_soft, name_the_end, name_the_impossible};
use crate::model::conditions::Conditions;
use crate::model::drive::Drive;
use crate::model::ending::{Ending, Leak, Snap};
use crate::model::state::State;
use crate::report::{Attempt, Cause, Strategy, Termination};
use crate::sqp::increment;
use crate::sqp::lowest_mode::LowestMode;
use crate::sqp::run::Run;
use crate::sqp::trend::Trend;
use checkpoint::Checkpoint;
use initial_penetration::InitialPenetration;
use leak_bracket::LeakBracket;
use longest_part::{MOST_PARTS, longest_part};
use part::solve_part;
use parts::Parts;
use penalty::{next_penalty, penalise};
use seal_trend::SealTrend;
use snap_through::snap_through;
use strategy::{Failure, LEAST_UNSTABLE_FRACTION, Next, Rules, Tried, after};

constants! {
    /// How far the first snap-through leads, over the longest part: what a smaller part would find is
    /// on the way down.
    const FIRST_SNAP_THROUGH: f64 = 1.0 / 2.0;
}

/// The path from one drive to another.
struct LoadPath<'w> {
    /// What drove the body at the start.
    start: Drive,
    /// What shall drive it at the end.
    goal: &'w Drive,
    /// By how much the start lies inside obstacles.
    penetration: InitialPenetration,
    /// Parts of the path.
    parts: Parts,
    /// Fraction of the path to which tools do not bound a part.
    least_bound: f64,
    /// All snap-throughs on the path.
    snapped: Option<Snap>,
    /// How far a snap-through leads: half as far after each that has found no minimum.
    snap_through: f64,
    /// A leak ahead; none where none was met.
    leak: Option<LeakBracket>,
    /// How tight seals are on the way.
    seals: SealTrend,
}

/// A part that failed, and the motion along which its equilibrium was seen to be unstable.
struct Failed {
    ending: Ending,
    lost: Option<LowestMode>,
    attempt: Attempt,
}

impl Failed {
    /// What decides what follows, by what is known at the last good state.
    fn as_seen_by(&self, run: &Run<'_>) -> Failure {
        let site = self.ending.site.as_ref();
        Failure {
            cause: self.ending.cause,
            is_unmet: site.is_some_and(|site| site.unbalanced.is_some()),
            is_soft: is_soft(run),
            is_certified: run.learned.lowest_mode.is_some(),
        }
    }
}

/// Moves the state to `goal`, in parts where the whole fails; returns how it ended and the part
/// reached.
pub(crate) fn advance(run: &mut Run<'_>, goal: &Drive) -> (Ending, f64) {
    let start = run.state.drive.clone();
    let goal = &goal.carried_by(&start);
    let mut penetration = InitialPenetration::of(&run.model, run.state, &start);
    if penetration.is_any() && goal.seeks_blow_off(&start) {
        // The pressure that is sought is that of a body in equilibrium, not on its way out of obstacles.
        let (ending, _) = advance(run, &start);
        if ending.termination != Termination::Converged {
            return (ending, 0.0);
        }
        penetration = InitialPenetration::none();
    }
    let longest = longest_part(&run.model, run.state, goal);
    let mut path = LoadPath {
        start,
        goal,
        parts: Parts::new(longest),
        least_bound: (1.0 - longest) / MOST_PARTS,
        penetration,
        snapped: None,
        snap_through: first_snap_through(run.state),
        leak: None,
        seals: SealTrend::default(),
    };
    path.bound_by_seals(run);
    let (mut ending, part) = path.follow(run);
    if ending.termination == Termination::Converged {
        run.learned.converged.add(run.counters.applications);
    }
    name_the_impossible(run, &mut ending, goal);
    ending.snapped = path.snapped;
    (ending, part)
}

impl LoadPath<'_> {
    /// Part after part to the end; how it ended and the part reached.
    fn follow(&mut self, run: &mut Run<'_>) -> (Ending, f64) {
        loop {
            // Nothing polls where a part needs no iteration.
            if let Some(termination) = run.stopped() {
                let ending = increment::stopped(run, termination);
                return self.finished(run, ending);
            }
            let next = self.parts.next();
            let checkpoint = Checkpoint::of(run);
            let before = run.counters.applications;
            let drive = self.start.towards(self.goal, next);
            let ending = solve_part(&mut run.under(self.conditions(run, next)), &drive);
            note_trend(run, &ending, &checkpoint.state);
            if ending.termination == Termination::Converged {
                if next >= 1.0 {
                    return (ending, 1.0);
                }
                self.parts.succeed();
                self.bound(run);
                if let Some(ending) = self.leaked(run, &ending) {
                    return self.finished(run, ending);
                }
                continue;
            }
            if let Some(leak) = ending.leak {
                checkpoint.restore(run);
                self.leak = Some(LeakBracket::new(next, leak, ending.cause));
                if let Some(ending) = self.leaked(run, &ending) {
                    return self.finished(run, ending);
                }
                continue;
            }
            let is_saddle = ending.cause == Some(Cause::UnstableEquilibrium);
            let failed = Failed {
                lost: run.learned.lowest_mode.clone().filter(|_| is_saddle),
                attempt: Attempt {
                    strategy: Strategy::Part,
                    cause: ending.cause,
                    preconditioner_applications: run.counters.applications - before,
                    followed_by: None,
                },
                ending,
            };
            checkpoint.restore(run);
            if failed.ending.is_stopped() {
                return self.finished(run, failed.ending);
            }
            self.parts.failures += 1;
            let settled = {
                let run = &mut run.under(self.conditions(run, self.parts.reached));
                self.after_failure(run, failed)
            };
            if let Some(ending) = settled {
                return self.finished(run, ending);
            }
        }
    }

    /// The end of a path on which a fluid leaks, where that is bracketed, or where its way is open before
    /// it has a pressure; else the next part halves the bracket.
    fn leaked(&mut self, run: &mut Run<'_>, last: &Ending) -> Option<Ending> {
        let bracket = self.leak?;
        let reached = self.parts.reached;
        let path = [&self.start, self.goal];
        let is_open = seal_trend::is_open(&run.model, run.state, bracket.fluid());
        if !is_open && !bracket.is_narrow(run.model.plan, path, reached) {
            self.parts.part = self.parts.part.min(bracket.half(reached));
            return None;
        }
        let leak = bracket.leak(path, reached);
        Some(self.leaking(run, (leak, bracket.cause()), last))
    }

    /// The end of a path at its last tight state, of a leak ahead and why nothing is tight there.
    fn leaking(
        &self,
        run: &mut Run<'_>,
        (leak, cause): (Leak, Option<Cause>),
        last: &Ending,
    ) -> Ending {
        let is_sought = self.goal.fluids[leak.fluid].to_blow_off;
        let mut ending = Ending {
            leak: Some(leak),
            termination: if is_sought {
                Termination::Converged
            } else {
                Termination::NotConverged
            },
            cause: cause.filter(|_| !is_sought),
            site: fluid_front::site(run, leak),
            ..last.clone()
        };
        increment::describe(run, &mut ending);
        ending
    }

    /// The end of a path on which nothing leads on, at its last good state: below a leak it is that of
    /// the leak, as far as that is bracketed.
    fn given_up(&self, run: &mut Run<'_>, mut ending: Ending) -> Ending {
        if let Some(bracket) = self.leak {
            let leak = bracket.leak([&self.start, self.goal], self.parts.reached);
            let wide = self.leaking(run, (leak, None), &ending);
            return Ending {
                termination: Termination::NotConverged,
                cause: ending.cause,
                ..wide
            };
        }
        name_the_end(run, &mut ending);
        increment::describe(run, &mut ending);
        ending
    }

    /// Does what follows a failed part; how the path ends where nothing leads on. The state is the
    /// last good one.
    fn after_failure(&mut self, run: &mut Run<'_>, failed: Failed) -> Option<Ending> {
        let failure = failed.as_seen_by(run);
        let rules = rules(run);
        let mut tried = self.tried(run);
        let mut attempt = failed.attempt;
        loop {
            let next = after(&failure, &tried, &rules);
            attempt.followed_by = next.strategy();
            let noted = run.counters.attempts.len();
            run.counters.attempts.push(attempt);
            let strategy = match next {
                Next::Again(strategy) => strategy,
                Next::Smaller => {
                    self.parts.cut_back();
                    run.counters.cut_backs += 1;
                    return None;
                }
                Next::GiveUp => return Some(self.given_up(run, failed.ending)),
            };
            let before = run.counters.applications;
            tried.note(strategy);
            let settled = if strategy == Strategy::SnapThrough {
                self.snap_through(run, &failure)
            } else {
                self.penalise(run, failed.lost.as_ref())
            };
            let Some(settled) = settled else {
                // A penalty that the scene has no place for is no attempt.
                run.counters.attempts.truncate(noted);
                continue;
            };
            if settled.is_stopped() {
                return Some(settled);
            }
            if settled.leak.is_some() {
                return self.leaked(run, &settled);
            }
            if settled.termination == Termination::Converged {
                return (self.parts.reached >= 1.0).then_some(settled);
            }
            tried.snap_through = self.snap_through;
            attempt = Attempt {
                strategy,
                cause: settled.cause,
                preconditioner_applications: run.counters.applications - before,
                followed_by: None,
            };
        }
    }

    /// What has been tried since the last equilibrium.
    fn tried(&self, run: &Run<'_>) -> Tried {
        Tried {
            half: self.parts.half(),
            longest: self.parts.longest,
            snap_through: self.snap_through,
            failures: self.parts.failures,
            penalty: false,
            has_snapped: false,
            is_spent: run.is_spent(),
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
        self.parts.bound(if share < 1.0 {
            ((1.0 - self.parts.reached) * share).max(self.least_bound)
        } else {
            1.0
        });
        self.bound_by_seals(run);
    }

    /// Bounds the next part by what fluids may rise from here; until a part has failed, by that alone.
    fn bound_by_seals(&mut self, run: &Run<'_>) {
        let share = self.seals.longest_part(&run.model, run.state, self.goal);
        if share < 1.0 {
            let longest = ((1.0 - self.parts.reached) * share).min(self.parts.longest);
            if run.counters.attempts.is_empty() {
                self.parts.part = longest;
            }
            self.parts.bound(longest);
        }
    }

    /// Brings a larger penalty in where that keeps an equilibrium; how that ended, the state as it
    /// was where it failed. None where no penalty is to be had.
    fn penalise(&mut self, run: &mut Run<'_>, lost: Option<&LowestMode>) -> Option<Ending> {
        let weight = next_penalty(run, lost, self.parts.tried)?;
        let settled = penalise(run, weight);
        if settled.termination == Termination::Converged {
            self.parts.failures = 0;
        } else {
            self.parts.tried = weight;
        }
        Some(settled)
    }

    /// Lets the body snap through to the next minimum a part of the path on; how that ended, the
    /// state as it was where none is found.
    fn snap_through(&mut self, run: &mut Run<'_>, failure: &Failure) -> Option<Ending> {
        let checkpoint = Checkpoint::of(run);
        let next = self.parts.after(self.snap_through * self.parts.longest);
        let drive = self.start.towards(self.goal, next);
        let settled = snap_through(&mut run.under(self.conditions(run, next)), &drive);
        if settled.termination == Termination::Converged {
            self.parts.land(next);
            self.bound(run);
            let was_lost = failure.is_unstable();
            let snap = settled.snapped.map(|snap| Snap { was_lost, ..snap });
            self.snapped = match (self.snapped, snap) {
                (Some(before), Some(snap)) => Some(before.and(snap)),
                (before, snap) => before.or(snap),
            };
        } else {
            checkpoint.restore(run);
            self.snap_through *= 0.5;
            let leak = settled.leak;
            let ahead = leak.map(|leak| LeakBracket::new(next, leak, settled.cause));
            self.leak = ahead.or(self.leak);
        }
        Some(settled)
    }

    /// The end of a path that leads no further than its last good part; an increment that was
    /// cancelled keeps none, one whose time is up all that are equilibria.
    fn finished(&self, run: &Run<'_>, mut ending: Ending) -> (Ending, f64) {
        let is_kept = match ending.termination {
            Termination::Converged | Termination::NotConverged => true,
            Termination::DeadlineExceeded => !self.penetration.is_any(),
            Termination::Cancelled | Termination::InternalError => false,
        };
        let mode = run.learned.lowest_mode.as_ref();
        ending.stability = mode.map(|mode| mode.stability);
        (ending, if is_kept { self.parts.reached } else { 0.0 })
    }
}

/// How far the first snap-through leads. A body at rest leans to no side yet: small parts bend it
/// first, so that it goes where it would under a slow press.
fn first_snap_through(state: &State) -> f64 {
    let is_at_rest = state.displacement.iter().all(|&u| u == 0.0);
    if is_at_rest {
        LEAST_UNSTABLE_FRACTION
    } else {
        FIRST_SNAP_THROUGH
    }
}

/// What the scene lets a load path do.
fn rules(run: &Run<'_>) -> Rules {
    let plan = run.model.plan;
    let has_friction = plan.has_friction();
    Rules {
        is_linear: run.model.is_linear() && !has_friction,
        is_nested: plan.decisions.contact.method.is_nested(),
        has_friction: run.model.interfaces.friction.is_some(),
        may_snap_through: run.model.is_rubber() && plan.may_snap_through(),
        snaps_through: plan.snaps_through(),
    }
}

/// Keeps how rubber moved in a part that converged.
fn note_trend(run: &mut Run<'_>, ending: &Ending, before: &State) {
    if run.model.is_rubber() && ending.termination == Termination::Converged {
        let known = run.learned.trend.take();
        run.learned.trend = Trend::noted(&run.model, known, before, run.state);
    }
}

/// The numeric constants of this room.
pub(crate) fn constants() -> Vec<crate::constants::Constant> {
    [
        fluid_front::own_constants(),
        leak_bracket::own_constants(),
        longest_part::own_constants(),
        own_constants(),
        parts::own_constants(),
        penalty::own_constants(),
        seal_trend::own_constants(),
        snap_through::own_constants(),
        strategy::own_constants(),
    ]
    .concat()
}
