//! What ends an increment, and why.
//!
//! Every loop of the solver ends in one of these; what the methods report in their own
//! words (`QpStatus`, `Outcome`) is brought to a termination and a cause here.

use super::run::Run;
use super::watch::Watch;
use crate::inequality::QpStatus;
use crate::krylov::Outcome;
use crate::report::{Cause, Termination};

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
    if worst <= run.model.tolerance && still {
        return Some(Verdict::stopped(Termination::Converged));
    }
    run.stopped().map(Verdict::stopped)
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
