//! Who reads a session: the stream that writes to it, and its watchers.
//!
//! Each reader has a cursor, the newest result that was queued for it; results
//! beyond it wait among the kept ones until its outbox has room. So a slow watcher
//! holds two results at most, the writer as many bytes as it asked for.

use std::collections::VecDeque;
use std::sync::Arc;

use signorini_proto::v1::{self as wire, solve_response::Message};

use super::iterations::Newest;
use super::kept::Kept;
use super::outbox::{Outbox, StreamEnd};
use crate::fault::Fault;
use crate::fault::status;

/// A result that is new in the session.
pub(crate) struct Fresh {
    pub(crate) event: i64,
    /// The last iteration before it.
    pub(crate) iteration: Newest,
}

/// A finished or running sequence that is sent again.
struct Repeat {
    sequence: i64,
    /// Next event to send.
    next: i64,
    /// Last event to send.
    last: i64,
}

/// One open stream.
pub(crate) struct Reader {
    pub(crate) outbox: Arc<Outbox>,
    /// Event of the newest result queued in order.
    cursor: i64,
    /// Results up to this event came before this stream, to nobody's knowledge.
    missed: i64,
    repeats: VecDeque<Repeat>,
}

impl Reader {
    /// A reader of results after the event `start`, of which the client has not
    /// seen those up to `missed`.
    pub(crate) fn new(outbox: Arc<Outbox>, start: i64, missed: i64) -> Self {
        Self {
            outbox,
            cursor: start,
            missed,
            repeats: VecDeque::new(),
        }
    }

    /// Event of the newest result queued in order.
    pub(crate) fn cursor(&self) -> i64 {
        self.cursor
    }

    /// Sequences that are still to be sent again.
    pub(crate) fn repeats(&self) -> usize {
        self.repeats.len()
    }

    /// Sends the results of a finished sequence again.
    pub(crate) fn repeat(&mut self, sequence: i64, kept: &Kept) {
        self.send_again(sequence, kept, i64::MAX);
    }

    /// Sends those results of the running sequence that this stream has missed.
    pub(crate) fn repeat_missed(&mut self, sequence: i64, kept: &Kept) {
        let missed = std::mem::take(&mut self.missed);
        self.send_again(sequence, kept, missed);
    }

    fn send_again(&mut self, sequence: i64, kept: &Kept, most: i64) {
        if let Some((next, last)) = kept.events_of(sequence) {
            let last = last.min(most);
            self.repeats.push_back(Repeat {
                sequence,
                next,
                last,
            });
        }
    }

    /// Queues what fits; true when nothing is left to queue and more would fit.
    pub(crate) fn feed(&mut self, kept: &Kept, fresh: Option<&Fresh>) -> bool {
        while self.outbox.has_room() {
            if self.feed_repeat(kept) {
                continue;
            }
            let Some(result) = kept.after(self.cursor) else {
                return true;
            };
            if result.event > self.cursor + 1 {
                self.outbox.end(StreamEnd::Fault(fell_behind(kept)));
                return true;
            }
            self.cursor = result.event;
            let fresh = fresh.filter(|fresh| fresh.event == result.event);
            self.outbox
                .result(result, fresh.map(|fresh| fresh.iteration.clone()));
        }
        false
    }

    /// Queues the next result that is sent again, if there is one.
    fn feed_repeat(&mut self, kept: &Kept) -> bool {
        let Some(repeat) = self.repeats.front_mut() else {
            return false;
        };
        if repeat.next > repeat.last {
            self.repeats.pop_front();
            return true;
        }
        match kept.after(repeat.next - 1) {
            Some(result) if result.event == repeat.next => {
                repeat.next += 1;
                self.outbox.result(result, None);
            }
            Some(_) | None => {
                // It left retention while it waited for room.
                self.outbox.push(lost(repeat.sequence, kept));
                self.repeats.pop_front();
            }
        }
        true
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        // The first end stays, so this one reaches only the stream of an actor
        // that died.
        self.outbox.end(StreamEnd::Fault(Fault::Internal));
    }
}

fn fell_behind(kept: &Kept) -> Fault {
    let (sequence, first) = (kept.first_sequence() - 1, kept.first_sequence());
    Fault::SequenceNotRetained { sequence, first }
}

fn lost(sequence: i64, kept: &Kept) -> Message {
    let first = kept.first_sequence();
    let fault = Fault::SequenceNotRetained { sequence, first };
    Message::UpdateRejected(wire::UpdateRejected {
        sequence,
        status: Some(status::rpc_status(&fault)),
    })
}
