//! What ends an increment, and why.
//!
//! Every loop of the solver ends in one of these; what the methods report in their own
//! words (`QpStatus`, `Outcome`) is brought to a termination and a cause here.

use super::run::Run;
use super::watch::Watch;
use crate::inequality::QpStatus;
use crate::krylov::Outcome;
use crate::linalg::vector::{largest, norm};
use crate::model::Model;
use crate::model::state::State;
use crate::report::{Cause, Termination};

constants! {
    /// Lengths of the body, for each that tools and supports travel, beyond which a body that no
    /// support holds has been thrown away: its forces are rounding of what they would be there.
    const FLOWN: f64 = 1e2;
}

/// How an increment ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Verdict {
    /// Whether the increment converged, was stopped or failed.
    pub(crate) termination: Termination,
    /// Why it did not converge; none where it did.
    pub(crate) cause: Option<Cause>,
}

impl Verdict {
    /// Not converged.
    pub(crate) fn failed(cause: Cause) -> Self {
        Self {
            termination: Termination::NotConverged,
            cause: Some(cause),
        }
    }

    /// Converged, or ended from outside.
    pub(crate) fn stopped(termination: Termination) -> Self {
        Self {
            termination,
            cause: None,
        }
    }
}

/// Whether the present state, with `worst` its largest residual, ends the increment;
/// `still` says that supports are where they shall be.
pub(crate) fn verdict(run: &Run<'_>, worst: f64, still: bool) -> Option<Verdict> {
    if !worst.is_finite() {
        return Some(Verdict::failed(Cause::NotFinite));
    }
    if worst <= run.model.conditions.tolerance && still {
        return Some(if has_flown(&run.model, run.state) {
            Verdict::failed(Cause::NotFinite)
        } else {
            Verdict::stopped(Termination::Converged)
        });
    }
    run.stopped().map(Verdict::stopped)
}

/// Whether a floating body is farther away than anything could have carried it.
fn has_flown(model: &Model<'_>, state: &State) -> bool {
    if !model.plan.is_floating() {
        return false;
    }
    let drive = &state.drive;
    let tools = drive.poses.iter().map(|pose| norm(&pose.translation));
    let supports = drive.motions.iter().map(|motion| norm(&motion.translation));
    let held = drive.supports.iter().map(|components| norm(components));
    let ways = tools.chain(supports).chain(held);
    let travel = ways.fold(0.0, f64::max) / model.plan.problem.units.length;
    largest(&state.displacement) > FLOWN * (1.0 + travel)
}

/// How a program's end ends the increment; none where the program was solved.
pub(crate) fn of_status(status: QpStatus, watch: &Watch<'_>) -> Option<Verdict> {
    let cause = match status {
        QpStatus::Solved => return None,
        QpStatus::Interrupted => {
            let stopped = watch.cancel.stopped().unwrap_or(Termination::Cancelled);
            return Some(Verdict::stopped(stopped));
        }
        QpStatus::Unsupported => return Some(Verdict::stopped(Termination::InternalError)),
        QpStatus::ActiveSetCycle => Cause::ActiveSetCycle,
        QpStatus::IndefiniteMetric | QpStatus::Krylov(Outcome::Indefinite) => {
            Cause::IndefiniteTangent
        }
        QpStatus::TooLarge | QpStatus::Krylov(Outcome::IterationLimit) => Cause::IterationLimit,
        QpStatus::Krylov(Outcome::Stagnation | Outcome::Stopped) => Cause::Stagnation,
        QpStatus::Krylov(Outcome::NotFinite) => Cause::NotFinite,
    };
    Some(Verdict::failed(cause))
}
