//! Steps that shall stop: cancelled, out of time, or left behind.

use signorini::report::Termination;

use super::{Actor, Place};
use crate::session::SessionEnd;
use crate::session::queue::look_again;
use crate::session::work::{self, Checkpoint, Increment, Work};

impl Actor {
    /// Finishes every step at the head of the queue that shall stop and that no
    /// solver thread has.
    pub(super) fn stop_here(&mut self) {
        while let Some(termination) = self.stopped_here() {
            self.finish_stopped(termination);
        }
    }

    fn stopped_here(&mut self) -> Option<Termination> {
        let current = self.queue.current()?;
        let termination = current.cancel.stopped()?;
        if let Place::Away(handoff) = &self.place {
            let Some(work) = work::take(handoff) else {
                current.start_patience(&self.events);
                return None;
            };
            self.place = Place::Home(work);
        }
        match self.place {
            Place::Lost(_) => None,
            Place::Preparing | Place::Home(_) | Place::Away(_) | Place::Behind => Some(termination),
        }
    }

    pub(super) fn cancel(&mut self, sequence: i64) -> i64 {
        let cancelled = self.queue.cancel(sequence);
        if let Some(sequence) = cancelled {
            self.log_cancelled(sequence);
        }
        cancelled.unwrap_or(0)
    }

    /// The time of a step is up.
    pub(super) fn deadline(&mut self, sequence: i64) {
        if let Some(accepted) = self.queue.find(sequence) {
            accepted.expire();
        }
    }

    /// A step had a slot as long as any may.
    pub(super) fn ceiling(&mut self, sequence: i64) {
        if let Some(accepted) = self.queue.find(sequence) {
            tracing::info!(sequence, "a step reached `maximum_step_seconds`");
            accepted.is_too_long = true;
            accepted.expire();
        }
    }

    /// Answers a step whose solver thread does not stop.
    pub(super) fn leave_behind(&mut self, sequence: i64) {
        let is_current = self.queue.current_sequence() == sequence;
        let Some(current) = self.queue.current().filter(|_| is_current) else {
            return;
        };
        let termination = current.cancel.stopped();
        if let (Place::Away(_), Some(termination)) = (&self.place, termination) {
            tracing::info!(sequence, "a step is left behind");
            self.place = Place::Behind;
            self.left_behind = sequence;
            look_again(sequence, &self.events);
            self.finish_stopped(termination);
        }
    }

    /// Counts a step whose solver thread has not stopped long after its answer.
    pub(super) fn count_stuck(&self, sequence: i64) {
        if matches!(self.place, Place::Behind) && self.left_behind == sequence {
            tracing::warn!(sequence, "a solver thread does not stop");
            self.services.metrics.left_behind();
        }
    }

    /// A thread that was left behind is back without having done anything.
    pub(super) fn come_home_late(&mut self, mut work: Box<Work>) {
        work.stop();
        self.place = Place::Home(work);
    }

    /// As `come_home_late`, after an increment: it was answered as not done.
    pub(super) fn undo_late(&mut self, mut work: Box<Work>, increment: &Increment) {
        let is_undone = increment.report.termination == Termination::Cancelled;
        let is_written = matches!(increment.checkpoint, Some(Checkpoint::Written(_)));
        if is_written && !is_undone {
            // It cannot be undone any more; the journal knows the state before.
            return self.end(SessionEnd::Interrupted(None));
        }
        work.take_back();
        self.place = Place::Home(work);
    }
}
