//! How equilibria of rubber are certified: by counting where a factor of the saddle point is
//! cheap beside an increment, else by the sign of the least eigenvalue.

use super::estimate::MOST_FACTOR_FLOPS;
use super::{Plan, estimate};
use crate::scene::StabilityCheck;

/// Floating-point operations of the largest factor that certifies unasked: a fraction of
/// a second.
pub(super) const CHEAP: f64 = 4e8;

/// The check of a plan, and why it is that.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StabilityChoice {
    /// What is done after each equilibrium.
    pub(crate) check: StabilityCheck,
    /// Why.
    pub(crate) reason: &'static str,
}

/// The check that the scene names, or the one that its size asks for.
///
/// Friction has no energy whose minimum an equilibrium could be: nothing is certified.
pub(super) fn choose(
    (named, is_frictional): (Option<StabilityCheck>, bool),
    flops: f64,
) -> StabilityChoice {
    match named {
        _ if is_frictional => StabilityChoice {
            check: StabilityCheck::Off,
            reason: "friction has no energy",
        },
        Some(check) => StabilityChoice {
            check,
            reason: "asked for",
        },
        None if flops <= CHEAP => StabilityChoice {
            check: StabilityCheck::Exact,
            reason: "a factor of the tangent is cheap",
        },
        None => StabilityChoice {
            check: StabilityCheck::Follow,
            reason: "a factor of the tangent is dear",
        },
    }
}

impl Plan {
    /// Whether a factor of the saddle point, by which unstable motions are counted, is small enough
    /// to be made.
    pub(crate) fn counts_motions(&self) -> bool {
        estimate::saddle_factor(self.problem.units.dimension, self.problem.unknowns).1
            <= MOST_FACTOR_FLOPS
    }

    /// Whether equilibria are certified by Lanczos steps.
    pub(super) fn certifies_by_steps(&self) -> bool {
        let is_rubber = self.problem.resolved.is_rubber();
        is_rubber
            && match self.decisions.stability.check {
                StabilityCheck::Exact => !self.counts_motions(),
                StabilityCheck::Follow => true,
                StabilityCheck::Off => false,
            }
    }

    /// The check in words, with its cost.
    pub(super) fn stability_in_words(&self) -> String {
        let flops = estimate::saddle_factor(self.problem.units.dimension, self.problem.unknowns).1;
        match self.decisions.stability.check {
            StabilityCheck::Exact if !self.counts_motions() => format!(
                "sign of the least eigenvalue by Lanczos steps, 15 to 60 applications an equilibrium, more where it is near zero: counting unstable motions takes {:.0} Gflop, above {:.0}",
                flops / 1e9,
                MOST_FACTOR_FLOPS / 1e9
            ),
            StabilityCheck::Exact => {
                format!(
                    "unstable motions counted, {:.1} Gflop an equilibrium",
                    flops / 1e9
                )
            }
            StabilityCheck::Follow => {
                "sign of the least eigenvalue by Lanczos steps, 15 to 60 applications an equilibrium, more where it is near zero"
                    .into()
            }
            StabilityCheck::Off => "not checked".into(),
        }
    }
}
