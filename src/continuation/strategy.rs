//! What follows a part of a load path that failed: the only place that decides.
//!
//! | failure | next |
//! |---|---|
//! | one that fails in every part alike, or the increment is spent | give up |
//! | an equilibrium seen to be lost, where bodies do not snap through | a volume penalty |
//! | any other, or the penalty did not help | a smaller part |
//! | no smaller part is left, along a motion of the mesh | a volume penalty |
//! | no smaller part is left, the equilibrium is lost | snap-through |
//! | nothing of these is left | give up |
//!
//! Fractions are of the load path, in (0, 1].

use crate::report::{Cause, Strategy};

constants! {
    /// Smallest part of an increment that cut-backs try: what fails there fails anew after each small
    /// part.
    const LEAST_FRACTION: f64 = 1.0 / 64.0;
    /// The same of the longest part, where tools bound it to less.
    const LEAST_BOUNDED_FRACTION: f64 = 1.0 / 4.0;
    /// Smallest part of the longest one that looks for the last minimum: near the end of stability
    /// every part is dear, and none leads far.
    pub(super) const LEAST_UNSTABLE_FRACTION: f64 = 1.0 / 8.0;
    /// Failures one after the other that bring a volume penalty in.
    const PATIENCE: u32 = 2;
    /// The same with friction, where no certificate says that a state is soft: the iterations stop
    /// where it is, and smaller parts only come nearer.
    const PATIENCE_WITH_FRICTION: u32 = 1;
}

/// A part that failed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Failure {
    /// Why; none where no cause is known.
    pub(super) cause: Option<Cause>,
    /// Whether an obstacle does not exert what it shall.
    pub(super) is_unmet: bool,
    /// Whether the last equilibrium has grown soft.
    pub(super) is_soft: bool,
    /// Whether the least eigenvalue of the last equilibrium is known.
    pub(super) is_certified: bool,
}

/// What the scene lets the load path do.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rules {
    /// Whether the end alone decides, not the path: no finite strain, no friction.
    pub(super) is_linear: bool,
    /// Whether contact is solved by a nested method, which spends its products.
    pub(super) is_nested: bool,
    /// Whether any obstacle is frictional.
    pub(super) has_friction: bool,
    /// Whether the equilibrium of rubber may be lost and snap through to the next minimum.
    pub(super) may_snap_through: bool,
    /// Whether contact pressure on its own lets it, so that a penalty comes in last.
    pub(super) snaps_through: bool,
}

/// Where the path is, and what has been tried since the last equilibrium.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tried {
    /// Half of the part that failed.
    pub(super) half: f64,
    /// Longest part that may be taken from here.
    pub(super) longest: f64,
    /// How far a snap-through would lead, over the longest part.
    pub(super) snap_through: f64,
    /// Failures one after the other.
    pub(super) failures: u32,
    /// Whether a larger penalty was tried after this failure.
    pub(super) penalty: bool,
    /// Whether a snap-through of that length was tried after this failure.
    pub(super) has_snapped: bool,
    /// Whether the increment has cost so much that what fails ends it.
    pub(super) is_spent: bool,
}

/// What the path does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// Something else at the same load.
    Again(Strategy),
    /// Half of the part.
    Smaller,
    /// The increment ends.
    GiveUp,
}

impl Next {
    /// The strategy that is tried next; none where the increment ends.
    pub(super) fn strategy(self) -> Option<Strategy> {
        match self {
            Self::Again(strategy) => Some(strategy),
            Self::Smaller => Some(Strategy::SmallerPart),
            Self::GiveUp => None,
        }
    }
}

impl Tried {
    /// Notes that `strategy` is tried.
    pub(super) fn note(&mut self, strategy: Strategy) {
        self.penalty |= strategy == Strategy::VolumePenalty;
        self.has_snapped |= strategy == Strategy::SnapThrough;
    }
}

/// What follows `failure`.
pub(super) fn after(failure: &Failure, tried: &Tried, rules: &Rules) -> Next {
    if tried.is_spent || !failure.depends_on_path(rules) {
        return Next::GiveUp;
    }
    let penalty = !tried.penalty && failure.is_lost(tried, rules);
    if penalty && !rules.snaps_through {
        return Next::Again(Strategy::VolumePenalty);
    }
    if tried.half >= failure.least_fraction(tried, rules) {
        return Next::Smaller;
    }
    if penalty {
        return Next::Again(Strategy::VolumePenalty);
    }
    if !tried.has_snapped && failure.may_snap_through(tried, rules) {
        return Next::Again(Strategy::SnapThrough);
    }
    Next::GiveUp
}

impl Failure {
    /// Whether smaller parts may lead further. A linear problem that fails as a whole fails in
    /// parts too, and so do a nested method that spends its products, a push that is not met, and
    /// a volume that cannot change.
    fn depends_on_path(&self, rules: &Rules) -> bool {
        let is_spent = rules.is_nested && self.cause == Some(Cause::IterationLimit);
        let is_general = is_spent || self.cause == Some(Cause::EnclosedVolume) || self.is_unmet;
        (!rules.is_linear && !is_general) || self.cause == Some(Cause::ActiveSetCycle)
    }

    /// Whether the equilibrium was seen to be unstable, or nearly so.
    pub(super) fn is_unstable(&self) -> bool {
        self.cause == Some(Cause::UnstableEquilibrium) || self.is_soft
    }

    /// Whether the equilibrium is lost in a way that a penalty may hold.
    fn is_lost(&self, tried: &Tried, rules: &Rules) -> bool {
        if rules.snaps_through {
            return self.cause == Some(Cause::UnstableEquilibrium);
        }
        let patience = if rules.has_friction {
            PATIENCE_WITH_FRICTION
        } else {
            PATIENCE
        };
        self.is_unstable() || tried.failures >= patience
    }

    /// Whether the body may snap through, and has not done so in vain too often.
    fn may_snap_through(&self, tried: &Tried, rules: &Rules) -> bool {
        let is_elsewhere = matches!(
            self.cause,
            Some(
                Cause::NoEquilibrium | Cause::EnclosedVolume | Cause::NotFinite | Cause::InsideOut
            )
        );
        let is_lost =
            self.is_unstable() || !self.is_certified || self.cause == Some(Cause::ActiveSetCycle);
        let is_left = tried.snap_through >= LEAST_UNSTABLE_FRACTION;
        rules.may_snap_through && is_left && is_lost && !is_elsewhere
    }

    /// Smallest part that is tried after the failure: what a smaller one than a snap-through would
    /// find is on its way.
    fn least_fraction(&self, tried: &Tried, rules: &Rules) -> f64 {
        if !self.is_unstable() {
            return LEAST_FRACTION.min(LEAST_BOUNDED_FRACTION * tried.longest);
        }
        let over_longest = if self.may_snap_through(tried, rules) {
            tried.snap_through
        } else {
            LEAST_UNSTABLE_FRACTION
        };
        over_longest * tried.longest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALLER: Next = Next::Smaller;
    const PENALTY: Next = Next::Again(Strategy::VolumePenalty);
    const SNAP: Next = Next::Again(Strategy::SnapThrough);
    const END: Next = Next::GiveUp;

    /// A first failure with a part of that half left.
    fn first(half: f64) -> Tried {
        Tried {
            half,
            longest: 1.0,
            snap_through: 0.5,
            failures: 1,
            penalty: false,
            has_snapped: false,
            is_spent: false,
        }
    }

    fn failed(cause: Cause) -> Failure {
        Failure {
            cause: Some(cause),
            is_certified: true,
            ..Failure::default()
        }
    }

    /// Rules of rubber that does not snap through, that does under functions of the vertices,
    /// that does on its own, and of a linear body.
    fn rules() -> [Rules; 4] {
        let held = Rules::default();
        let may = Rules {
            may_snap_through: true,
            ..held
        };
        let snaps = Rules {
            snaps_through: true,
            ..may
        };
        let linear = Rules {
            is_linear: true,
            ..held
        };
        [held, may, snaps, linear]
    }

    #[test]
    fn every_failure_has_one_answer() {
        // Cause; for each of the rules with a large part, and with the smallest one.
        let table = [
            (
                Cause::Stagnation,
                [SMALLER, SMALLER, SMALLER, END],
                [END, END, END, END],
            ),
            (
                Cause::LineSearch,
                [SMALLER, SMALLER, SMALLER, END],
                [END, END, END, END],
            ),
            (
                Cause::NegativeJacobian,
                [SMALLER, SMALLER, SMALLER, END],
                [END, END, END, END],
            ),
            (
                Cause::InsideOut,
                [SMALLER, SMALLER, SMALLER, END],
                [END, END, END, END],
            ),
            (
                Cause::NoEquilibrium,
                [SMALLER, SMALLER, SMALLER, END],
                [END, END, END, END],
            ),
            (
                Cause::ActiveSetCycle,
                [SMALLER, SMALLER, SMALLER, SMALLER],
                [END, SNAP, SNAP, END],
            ),
            (
                Cause::UnstableEquilibrium,
                [PENALTY, PENALTY, SMALLER, END],
                [PENALTY, PENALTY, PENALTY, END],
            ),
            (
                Cause::EnclosedVolume,
                [END, END, END, END],
                [END, END, END, END],
            ),
        ];
        for (cause, large, small) in table {
            for (half, expected) in [(0.5, large), (1e-3, small)] {
                let found = rules().map(|rules| after(&failed(cause), &first(half), &rules));
                assert_eq!(found, expected, "{cause:?}, half of the part {half}");
            }
        }
    }

    #[test]
    fn what_did_not_help_is_not_tried_again() {
        let lost = failed(Cause::UnstableEquilibrium);
        let [held, may, snaps, _] = rules();
        let penalised = Tried {
            penalty: true,
            ..first(1e-3)
        };
        assert_eq!(after(&lost, &penalised, &held), END);
        for rules in [may, snaps] {
            assert_eq!(after(&lost, &penalised, &rules), SNAP);
            let snapped = Tried {
                has_snapped: true,
                ..penalised
            };
            assert_eq!(after(&lost, &snapped, &rules), END);
        }
    }

    #[test]
    fn a_snap_through_that_led_nowhere_leaves_smaller_parts() {
        let lost = failed(Cause::UnstableEquilibrium);
        let [_, _, snaps, _] = rules();
        let tried = |half: f64, snap_through: f64| Tried {
            penalty: true,
            has_snapped: true,
            snap_through,
            ..first(half)
        };
        assert_eq!(after(&lost, &tried(0.3, 0.5), &snaps), END);
        assert_eq!(after(&lost, &tried(0.3, 0.25), &snaps), SMALLER);
        assert_eq!(after(&lost, &tried(0.13, 0.1), &snaps), SMALLER);
    }

    #[test]
    fn failures_one_after_the_other_bring_a_penalty_in() {
        let stuck = failed(Cause::Stagnation);
        let [held, ..] = rules();
        let second = Tried {
            failures: 2,
            ..first(0.5)
        };
        assert_eq!(after(&stuck, &second, &held), PENALTY);
        let frictional = Rules {
            has_friction: true,
            ..held
        };
        assert_eq!(after(&stuck, &first(0.5), &frictional), PENALTY);
    }

    #[test]
    fn an_increment_that_is_spent_or_whose_push_is_not_met_ends() {
        let stuck = failed(Cause::Stagnation);
        let unmet = Failure {
            is_unmet: true,
            ..stuck
        };
        let spent = Tried {
            is_spent: true,
            ..first(0.5)
        };
        for rules in rules() {
            assert_eq!(after(&unmet, &first(0.5), &rules), END);
            assert_eq!(after(&stuck, &spent, &rules), END);
        }
    }

    #[test]
    fn where_tools_bound_parts_a_quarter_is_the_least() {
        let stuck = failed(Cause::Stagnation);
        let bounded = Tried {
            longest: 1e-3,
            ..first(3e-4)
        };
        assert_eq!(after(&stuck, &bounded, &rules()[0]), SMALLER);
    }
}
