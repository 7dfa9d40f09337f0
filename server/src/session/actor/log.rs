//! What a session leaves in the log: one line when it starts, for each step that
//! finished and when it ends; increments at level `debug`. The span names the session.
//!
//! Texts that clients chose go in as values, which the log quotes.

use signorini::report::{Cause, StepReport, Termination};

use super::Actor;
use crate::convert::mesh;
use crate::fault::status;
use crate::session::SessionEnd;
use crate::session::queue::Accepted;

impl Actor {
    pub(super) fn log_start(&self) {
        let plan = &self.spec.plan_report;
        tracing::info!(
            scene = status::shortened(&plan.name),
            mesh = mesh::name(self.spec.mesh.value().id()),
            displacement_unknowns = plan.unknowns.as_ref().map(|count| count.displacement),
            predicted_bytes = plan.predicted_bytes,
            client = %self.client,
            "session started"
        );
    }

    pub(super) fn log_end(&self, ending: &SessionEnd) {
        let age = self.spec.created.elapsed().unwrap_or_default();
        tracing::info!(
            ending = ending.name(),
            steps = self.last_finished,
            seconds = age.as_secs(),
            "session ended"
        );
    }
}

/// One increment that a solver finished.
pub(super) fn increment(report: &StepReport) {
    tracing::debug!(
        step = report.step,
        increment = report.increment,
        termination = report.termination.name(),
        cause = report.cause.map(Cause::name),
        krylov_iterations = report.krylov_iterations,
        seconds = report.seconds.total,
        "increment finished"
    );
}

/// One step that ended, however it did.
pub(super) fn step(finished: &Accepted, termination: Termination, cause: Option<Cause>) {
    let spent = finished.spent();
    tracing::info!(
        sequence = finished.sequence,
        termination = termination.name(),
        cause = cause.map(Cause::name),
        increments = finished.results,
        sqp_iterations = spent.sqp_iterations,
        krylov_iterations = spent.krylov_iterations,
        seconds = spent.seconds,
        "step finished"
    );
}
