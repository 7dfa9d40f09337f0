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

/// Where a stream begins.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Begin {
    /// Results after this event come in order.
    pub(crate) event: i64,
    /// Results up to this event came before this stream, to nobody's knowledge.
    pub(crate) missed: i64,
    /// Last sequence that was accepted before this stream. Of some of them the client does not
    /// know: it is told of those that the disk has.
    pub(crate) accepted: i64,
}

/// One open stream.
pub(crate) struct Reader {
    pub(crate) outbox: Arc<Outbox>,
    /// Event of the newest result queued in order.
    cursor: i64,
    begin: Begin,
    repeats: VecDeque<Repeat>,
}

impl Reader {
    /// A reader of results from `begin` on.
    pub(crate) fn new(outbox: Arc<Outbox>, begin: Begin) -> Self {
        Self {
            outbox,
            cursor: begin.event,
            begin,
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

    /// Sends the results of a finished sequence again. Those of one that was accepted before this
    /// stream come in order where they are newer than its begin, and then once.
    pub(crate) fn repeat(&mut self, sequence: i64, kept: &Kept) {
        let is_older = sequence <= self.begin.accepted;
        let most = if is_older { self.begin.event } else { i64::MAX };
        self.send_again(sequence, kept, most);
    }

    /// Sends those results of the running sequence that this stream has missed.
    pub(crate) fn repeat_missed(&mut self, sequence: i64, kept: &Kept) {
        let missed = std::mem::take(&mut self.begin.missed);
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

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::convert::field::Encoding;
    use crate::results::iterations::Iterations;
    use crate::results::kept::KeptResult;
    use crate::results::outbox::{Limit, Next, Wanted};

    /// Two results of each of three updates.
    fn kept() -> Kept {
        let mut kept = Kept::new(100, 1 << 20);
        for event in 1..=6 {
            kept.push(KeptResult {
                sequence: (event + 1) / 2,
                event,
                report: (&wire::StepReport::default()).into(),
                last: event % 2 == 0,
                asked: Some(Vec::new()),
                fields: Vec::new(),
                dropped: false,
                needs: 0,
            });
        }
        kept
    }

    fn reader(begin: Begin) -> Reader {
        let wanted = Wanted {
            fields: Vec::new(),
            encoding: Encoding::Double,
        };
        let limit = Limit {
            bytes: 1 << 20,
            results: 100,
        };
        Reader::new(Outbox::new(limit, wanted, &Arc::default()), begin)
    }

    /// The events that it is sent.
    async fn events(mut reader: Reader, kept: &Kept) -> Vec<i64> {
        reader.feed(kept, None);
        let outbox = Arc::clone(&reader.outbox);
        drop(reader);
        let iterations = Iterations::default();
        let mut none = iterations.reader(Duration::ZERO);
        let mut events = Vec::new();
        while let Next::Message(response) = outbox.next(&mut none, Duration::from_secs(60)).await {
            if let Some(Message::StepFinished(finished)) = response.message {
                events.push(finished.event);
            }
        }
        events
    }

    #[tokio::test]
    async fn an_update_that_the_client_did_not_know_to_be_accepted_has_its_results_once() {
        // It was accepted, its client was not told so, and it finished before it came again.
        let kept = kept();
        let mut reader = reader(Begin {
            event: 2,
            missed: 0,
            accepted: 2,
        });
        reader.feed(&kept, None);
        reader.repeat(2, &kept);
        assert_eq!(events(reader, &kept).await, [3, 4, 5, 6]);
    }

    #[tokio::test]
    async fn results_from_before_a_stream_are_sent_again_and_those_that_come_in_order_are_not() {
        let kept = kept();
        let mut reader = reader(Begin {
            event: 3,
            missed: 0,
            accepted: 3,
        });
        reader.repeat(2, &kept);
        assert_eq!(events(reader, &kept).await, [3, 4, 5, 6]);
    }

    #[tokio::test]
    async fn an_update_that_is_sent_again_on_its_own_stream_is_answered_again() {
        let kept = kept();
        let mut reader = reader(Begin {
            event: 0,
            missed: 0,
            accepted: 0,
        });
        reader.feed(&kept, None);
        reader.repeat(3, &kept);
        assert_eq!(events(reader, &kept).await, [1, 2, 3, 4, 5, 6, 5, 6]);
    }
}
