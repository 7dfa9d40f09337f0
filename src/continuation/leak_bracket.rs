//! Where on the load path a fluid leaks: between the last tight equilibrium and the first drive
//! under which it reaches what must stay dry,
//!
//! ```text
//! q(tight) <= blow-off pressure <= q(leaks),   q(leaks) - q(tight) <= tolerance q(leaks)
//! ```
//!
//! by bisection of the path, which is bracketed too, to the tolerance times its length: where the pressure stays
//! the same or nearly so it is a motion, such as that of an obstacle, at which the fluid leaks.

use crate::model::drive::Drive;
use crate::model::ending::Leak;
use crate::plan::Plan;
use crate::report::Cause;

constants! {
    /// Fraction of the path up to which a leak is bracketed at most, without unit: one that begins with the path
    /// itself has no pressure that a tolerance would be relative to. Chosen.
    const LEAST_WAY: f64 = 1e-6;
}

/// What is known of the leak ahead.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeakBracket {
    /// Fraction of the path where the fluid leaks.
    end: f64,
    /// The leak there.
    leak: Leak,
    /// Why there is no tight equilibrium there.
    cause: Option<Cause>,
}

impl LeakBracket {
    /// That of a leak at the fraction `end` of the path.
    pub(super) fn new(end: f64, leak: Leak, cause: Option<Cause>) -> Self {
        Self { end, leak, cause }
    }

    /// The fluid, by its place in the scene.
    pub(super) fn fluid(&self) -> usize {
        self.leak.fluid
    }

    /// Why there is no tight equilibrium at its end.
    pub(super) fn cause(&self) -> Option<Cause> {
        self.cause
    }

    /// Half of the way from `reached` to the leak.
    pub(super) fn half(&self, reached: f64) -> f64 {
        0.5 * (self.end - reached)
    }

    /// The leak with the pressures at both ends of the bracket.
    pub(super) fn leak(&self, path: [&Drive; 2], reached: f64) -> Leak {
        let at =
            |fraction: f64| path[0].towards(path[1], fraction).fluids[self.leak.fluid].pressure;
        Leak {
            pressures: [at(reached), at(self.end)],
            is_pushed_out: self.cause == Some(Cause::NoEquilibrium),
            ..self.leak
        }
    }

    /// Whether the bracket is as narrow as asked for: on the path, and in the pressure, which where it
    /// rises from far below is the shorter one.
    pub(super) fn is_narrow(&self, plan: &Plan, path: [&Drive; 2], reached: f64) -> bool {
        let tolerance = plan.problem.resolved.fluids[self.leak.fluid].blow_off_tolerance;
        let way = self.end - reached;
        let [low, high] = self.leak(path, reached).pressures;
        way <= LEAST_WAY || (way <= tolerance && (high - low).abs() <= tolerance * low.max(high))
    }
}
