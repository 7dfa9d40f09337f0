//! What a session does just now, as the live page shows it: numbers that its actor has at hand,
//! without fields, so that a look costs a running step nothing.

use signorini_proto::v1 as wire;

/// Warnings of one result that are shown.
const MOST_WARNINGS: usize = 8;

/// One look at a session.
pub(crate) struct Glance {
    /// Its description, without its plan.
    pub(crate) session: wire::Session,
    /// Accepted updates behind the current one.
    pub(crate) waiting: usize,
    /// The current update; none while the session has nothing to do.
    pub(crate) runs: Option<Runs>,
    /// The last increment that a solver finished.
    pub(crate) latest: Option<Latest>,
}

/// The current update, which runs or waits for a slot.
pub(crate) struct Runs {
    pub(crate) sequence: i64,
    /// Increments of its step, and those of them that are done.
    pub(crate) increments: u32,
    pub(crate) done: u32,
    /// The newest iteration; none before the first.
    pub(crate) iteration: Option<wire::IterationReport>,
}

/// What is shown of a finished increment.
pub(crate) struct Latest {
    pub(crate) step: i32,
    pub(crate) increment: i32,
    pub(crate) load: f64,
    pub(crate) termination: wire::Termination,
    /// Unspecified when it converged.
    pub(crate) cause: wire::Cause,
    /// The first of them.
    pub(crate) warnings: Vec<wire::Warning>,
}

impl Latest {
    pub(super) fn of(report: &wire::StepReport) -> Self {
        Self {
            step: report.step,
            increment: report.increment,
            load: report.load,
            termination: report.termination(),
            cause: report.cause(),
            warnings: report
                .warnings
                .iter()
                .take(MOST_WARNINGS)
                .cloned()
                .collect(),
        }
    }
}
