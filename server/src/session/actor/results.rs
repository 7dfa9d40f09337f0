//! From an increment that ended to a kept and sent result.

use super::{Actor, Fresh, Place, log};
use crate::compute::LONG;
use crate::convert::field::KeptField;
use crate::convert::report;
use crate::results::kept::{KeptReport, KeptResult};
use crate::results::unfinished;
use crate::session::ledger::Cost;
use crate::session::path::{Passage, Path};
use crate::session::work::{Checkpoint, Increment};
use signorini::report::{Cause, FieldName, Termination};
use signorini_proto::v1 as wire;

/// How an increment ended.
pub(super) struct Ending {
    pub(super) termination: Termination,
    pub(super) cause: Option<Cause>,
    /// What a replay would take for it.
    pub(super) cost: Cost,
    /// Where one was due after it.
    pub(super) checkpoint: Option<Checkpoint>,
}

impl Actor {
    pub(super) fn finish_increment(&mut self, increment: Increment) {
        self.state_bytes = increment.state_bytes;
        self.response = increment.response;
        let report = increment.report;
        self.was_long = report.seconds.total > LONG.as_secs_f64();
        self.services.metrics.increment(&report);
        log::increment(&report);
        if let Some(current) = self.queue.current() {
            current.spend(&report);
        }
        let ending = Ending {
            termination: report.termination,
            cause: report.cause,
            cost: match report.termination {
                Termination::Converged | Termination::NotConverged => increment.cost,
                Termination::Cancelled
                | Termination::DeadlineExceeded
                | Termination::InternalError => Cost::default(),
            },
            checkpoint: increment.checkpoint,
        };
        let report = report::step(report, increment.poses);
        self.last_report = Some(report.clone());
        self.deliver(&report, ending, increment.asked, increment.fields);
    }

    /// Finishes the current step with the last good state.
    pub(super) fn finish_stopped(&mut self, termination: Termination) {
        let Some(current) = self.queue.current() else {
            return;
        };
        let (step, increment) = (current.step_number(), current.results + 1);
        let blank = unfinished::report(step, increment, termination);
        self.services.metrics.increment(&blank);
        let blank = report::step(blank, Vec::new());
        let report = unfinished::stopped(self.last_report.as_ref(), blank);
        let (asked, fields) = match self.kept.newest() {
            // Of a last result fields are due, even if the newest has none.
            Some(newest) => (
                newest.asked.clone().unwrap_or_default(),
                newest.fields.clone(),
            ),
            None => (Vec::new(), Vec::new()),
        };
        match &mut self.place {
            Place::Home(work) => work.stop(),
            Place::Preparing => self.is_stopped_early = true,
            Place::Away(_) | Place::Behind | Place::Lost(_) => {}
        }
        let ending = Ending {
            termination,
            cause: None,
            cost: Cost::default(),
            checkpoint: None,
        };
        self.deliver(&report, ending, Some(asked), fields);
    }

    /// Keeps and sends a result; the last one finishes the step.
    pub(super) fn deliver(
        &mut self,
        report: &wire::StepReport,
        ending: Ending,
        asked: Option<Vec<FieldName>>,
        fields: Vec<KeptField>,
    ) {
        let (termination, cause) = (ending.termination, ending.cause);
        self.note_passage(&ending);
        let Some(current) = self.queue.current() else {
            return;
        };
        current.results += 1;
        let last = current.is_last(report, termination);
        let is_too_long = current.is_too_long && termination == Termination::DeadlineExceeded;
        self.last_event += 1;
        let mut kept = KeptReport::from(report);
        if is_too_long {
            let cause = wire::Cause::ServerTimeLimit.into();
            kept = KeptReport::from(&wire::StepReport {
                cause,
                ..report.clone()
            });
            self.services.metrics.server_time_limit();
        }
        let mut result = KeptResult {
            sequence: current.sequence,
            event: self.last_event,
            report: kept,
            last,
            asked,
            fields,
            dropped: false,
            needs: 0,
        };
        result.needs = self.log_result(&result, &ending);
        let result = self.kept.push(result);
        let fresh = Fresh {
            event: result.event,
            iteration: self.iterations.newest(),
        };
        self.feed(Some(&fresh));
        self.fresh = Some(fresh);
        if last {
            self.finish_step(termination, cause);
        }
        self.account();
    }

    /// Notes what the current update has just done to the state.
    fn note_passage(&mut self, ending: &Ending) {
        let Some(current) = self.queue.first() else {
            return;
        };
        let update = (current.sequence, &current.encoded);
        match (&ending.checkpoint, ending.termination) {
            (Some(Checkpoint::Written(state) | Checkpoint::Passed(state)), _) => {
                self.path = Path::at(state.clone());
            }
            (None, Termination::Converged | Termination::NotConverged) => {
                self.path.count(update, current.results, Passage::Done);
            }
            (
                None,
                Termination::Cancelled | Termination::DeadlineExceeded | Termination::InternalError,
            ) => self.path.count(update, current.results, Passage::Stopped),
        }
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
