//! From an increment that ended to a kept and sent result.

use super::{Actor, Fresh, Place, log};
use crate::compute::LONG;
use crate::convert::field::KeptField;
use crate::convert::report;
use crate::results::kept::{KeptReport, KeptResult};
use crate::results::unfinished;
use crate::session::work::Increment;
use signorini::ObstaclePose;
use signorini::report::{Cause, FieldName, StepReport, Termination};
use signorini_proto::v1 as wire;

impl Actor {
    pub(super) fn finish_increment(&mut self, increment: Increment) {
        self.state_bytes = increment.state_bytes;
        let report = increment.report;
        self.was_long = report.seconds.total > LONG.as_secs_f64();
        self.services.metrics.increment(&report);
        log::increment(&report);
        if let Some(current) = self.queue.current() {
            current.spend(&report);
        }
        self.last_report = Some(report.clone());
        self.last_poses.clone_from(&increment.poses);
        self.deliver(report, increment.poses, increment.asked, increment.fields);
    }

    /// Finishes the current step with the last good state.
    pub(super) fn finish_stopped(&mut self, termination: Termination) {
        let Some(current) = self.queue.current() else {
            return;
        };
        let (step, increment) = (current.step_number(), current.results + 1);
        let report = unfinished::stopped(self.last_report.as_ref(), step, increment, termination);
        self.services.metrics.increment(&report);
        let (asked, fields) = match self.kept.newest() {
            // Of a last result fields are due, even if the newest has none.
            Some(newest) => (
                newest.asked.clone().unwrap_or_default(),
                newest.fields.clone(),
            ),
            None => (Vec::new(), Vec::new()),
        };
        if let Place::Home(work) = &mut self.place {
            work.stop();
        }
        self.deliver(report, self.last_poses.clone(), Some(asked), fields);
    }

    /// Keeps and sends a result; the last one finishes the step.
    pub(super) fn deliver(
        &mut self,
        report: StepReport,
        poses: Vec<ObstaclePose>,
        asked: Option<Vec<FieldName>>,
        fields: Vec<KeptField>,
    ) {
        let (termination, cause) = (report.termination, report.cause);
        let Some(current) = self.queue.current() else {
            return;
        };
        current.results += 1;
        let last = current.is_last(&report);
        let is_too_long = current.is_too_long && termination == Termination::DeadlineExceeded;
        self.last_event += 1;
        let mut report = report::step(report, poses);
        if is_too_long {
            report.cause = wire::Cause::ServerTimeLimit.into();
            self.services.metrics.server_time_limit();
        }
        let result = self.kept.push(KeptResult {
            sequence: current.sequence,
            event: self.last_event,
            report: KeptReport::from(&report),
            last,
            asked,
            fields,
            dropped: false,
        });
        let fresh = Fresh {
            event: result.event,
            iteration: self.iterations.newest(),
        };
        self.feed(Some(&fresh));
        if last {
            self.finish_step(termination, cause);
        }
        self.account();
    }

    pub(super) fn finish_step(&mut self, termination: Termination, cause: Option<Cause>) {
        if let Some(finished) = self.queue.finish() {
            log::step(&finished, termination, cause);
            self.last_finished = finished.sequence;
            self.services.metrics.step(termination);
            if let Some(asked) = finished.cancelled_at {
                self.services.metrics.cancelled(asked.elapsed());
            }
        }
        if let Place::Home(work) = &mut self.place {
            work.forget();
        }
    }
}
