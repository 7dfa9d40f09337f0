//! Updates: accepted in sequence, repeated, or rejected inside the stream.

use signorini_proto::v1::{self as wire, solve_response::Message};
use tokio::time::Instant;

use super::Actor;
use crate::convert::step::Update;
use crate::fault::Fault;
use crate::fault::status;

impl Actor {
    pub(super) fn update(&mut self, update: Update) {
        if self.is_given_up() || self.goes_on_later() {
            // Neither accepted nor refused: its stream ends, and its client sends it again.
            return;
        }
        let sequence = update.sequence;
        if sequence < 1 {
            self.reject(sequence, &Fault::request("sequence", "must be at least 1"));
        } else if sequence <= self.queue.last_accepted() {
            self.repeat(sequence);
        } else if let Err(fault) = self.admit(sequence).and_then(|()| self.claim_response()) {
            self.reject(sequence, &fault);
        } else {
            let deadline = self.stream_deadline();
            let mark = self.log_update(&update);
            if let Some(accepted) = self.queue.push(update) {
                accepted.mark = mark;
                accepted.stream_ends_at(deadline, &self.events);
            }
        }
    }

    pub(super) fn admit(&self, received: i64) -> Result<(), Fault> {
        let config = &self.services.config;
        let expected = self.queue.last_accepted() + 1;
        if self.ending.is_some() {
            return Err(Fault::ShuttingDown);
        }
        self.services.check_data()?;
        if received != expected {
            return Err(Fault::SequenceGap { received, expected });
        }
        if self.queue.len() >= config.maximum_in_flight {
            let limit = config.maximum_in_flight;
            return Err(Fault::QueueFull { limit });
        }
        if self.services.solvers.waiting(self.client.identity) >= config.maximum_queued {
            let limit = config.maximum_queued;
            return Err(Fault::QueueFull { limit });
        }
        Ok(())
    }

    fn repeat(&mut self, sequence: i64) {
        let first = self.kept.first_sequence();
        let is_finished = sequence <= self.last_finished;
        if is_finished && sequence < first {
            return self.reject(sequence, &Fault::SequenceNotRetained { sequence, first });
        }
        let deadline = self.stream_deadline();
        if let Some(unfinished) = self.queue.find(sequence) {
            unfinished.stream_ends_at(deadline, &self.events);
        }
        let limit = self.services.config.maximum_in_flight;
        let is_current = sequence == self.queue.current_sequence();
        let Some(writer) = &mut self.writer else {
            return;
        };
        if writer.reader.repeats() >= limit {
            return self.reject(sequence, &Fault::QueueFull { limit });
        }
        if is_finished {
            writer.reader.repeat(sequence, &self.kept);
        } else if is_current {
            // Asked again after a new connection: what it missed; the rest follows.
            writer.reader.repeat_missed(sequence, &self.kept);
        }
        self.feed(None);
    }

    fn stream_deadline(&self) -> Option<Instant> {
        self.writer.as_ref()?.deadline
    }

    pub(super) fn reject(&self, sequence: i64, fault: &Fault) {
        self.services.metrics.refused(status::reason(fault));
        tracing::info!(
            sequence,
            reason = status::reason(fault),
            why = status::text(fault),
            "update refused"
        );
        if let Some(writer) = &self.writer {
            let status = Some(status::rpc_status(fault));
            let rejected = wire::UpdateRejected { sequence, status };
            writer.reader.outbox.push(Message::UpdateRejected(rejected));
        }
    }

    /// The current update was faulty; those after it have lost their place.
    pub(super) fn refuse_current(&mut self, fault: &Fault) {
        let expected = self.queue.current_sequence();
        self.log_withdrawn(expected);
        for refused in self.queue.refuse() {
            let received = refused.sequence;
            if received == expected {
                self.reject(received, fault)
            } else {
                self.reject(received, &Fault::SequenceGap { received, expected })
            }
        }
    }

    pub(super) fn refuse_all(&mut self, fault: &Fault) {
        self.log_withdrawn(self.queue.current_sequence());
        for refused in self.queue.refuse() {
            self.reject(refused.sequence, fault);
        }
        self.end_finished_streams();
    }
}
