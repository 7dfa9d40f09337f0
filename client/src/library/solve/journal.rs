//! What one stream still owes its user: the state machine that lets a broken
//! connection be replaced by another without losing or repeating a result.
//!
//! Sequences are gapless, so four numbers say where a session stands:
//! `finished <= sent <= tail` (the last sequence whose results are all handed
//! over, the last one that the server has, the last one that the user sent) and
//! `seen`, the last result handed over. Updates stay here until they are
//! finished; a new connection sends what the server did not accept, and drops
//! results up to `seen`. No network, no clock. Cost: a copy of each update.

use std::collections::{BTreeMap, VecDeque};

use signorini_proto::v1;
use signorini_proto::v1::solve_request::Message as Request;
use tonic::Code;

use super::events::{Event, Increment};
use crate::library::error::{ClientError, Refusal};

/// What a user asks for.
#[derive(Clone, Debug)]
pub(super) enum Order {
    /// An update with its sequence.
    Update(i64, Box<Request>),
    /// Cancels a sequence, 0 for the one that runs.
    Cancel(i64),
}

#[derive(Debug)]
struct Update {
    sequence: i64,
    request: Request,
}

#[derive(Debug)]
struct Cancel {
    /// As it goes to the server.
    sequence: i64,
    /// The sequence that it means, known here also for 0.
    target: i64,
    sent: bool,
}

/// Updates, cancels and results of one session's stream.
#[derive(Debug)]
pub(super) struct Journal {
    seen: i64,
    /// Whether the next result has to follow `seen` directly.
    contiguous: bool,
    finished: i64,
    sent: i64,
    tail: i64,
    /// Last sequence that the server is known to have finished.
    freed: i64,
    window: i64,
    updates: VecDeque<Update>,
    cancels: Vec<Cancel>,
    /// Sent after a rejected update; their own rejections are given already.
    doomed: VecDeque<i64>,
}

impl Journal {
    /// Starts from the first `opened`; `last_seen` as it was asked for.
    pub(super) fn new(last_seen: Option<i64>, opened: &v1::StreamOpened) -> Self {
        let (accepted, finished) = progress(opened);
        let newest = opened.last_event;
        Self {
            seen: last_seen.map_or(newest, |seen| seen.min(newest)),
            contiguous: last_seen.is_none(),
            finished,
            sent: accepted,
            tail: accepted,
            freed: finished,
            window: window(opened),
            updates: VecDeque::new(),
            cancels: Vec::new(),
            doomed: VecDeque::new(),
        }
    }

    /// Last result that was handed over.
    pub(super) fn seen(&self) -> i64 {
        self.seen
    }

    /// Whether every update is answered.
    pub(super) fn is_answered(&self) -> bool {
        self.updates.is_empty()
    }

    /// Whether the server has everything that the user sent.
    pub(super) fn is_sent(&self) -> bool {
        self.unsent().is_none() && self.cancels.iter().all(|cancel| cancel.sent)
    }

    /// Takes an order; an event when it is answered at once.
    pub(super) fn order(&mut self, order: Order) -> Option<Event> {
        match order {
            Order::Update(sequence, request) if sequence == self.tail + 1 => {
                self.tail = sequence;
                self.updates.push_back(Update {
                    sequence,
                    request: *request,
                });
                None
            }
            Order::Update(sequence, _) => Some(gap(sequence, self.tail + 1)),
            Order::Cancel(sequence) => {
                let target = match sequence {
                    0 => self.finished + 1,
                    sequence => sequence,
                };
                self.cancels.push(Cancel {
                    sequence,
                    target,
                    sent: false,
                });
                None
            }
        }
    }

    /// Whether [`Journal::next_request`] has one.
    pub(super) fn has_request(&self) -> bool {
        self.due_cancel().is_some() || self.due_update().is_some()
    }

    /// The next message that may go to the server now.
    pub(super) fn next_request(&mut self) -> Option<Request> {
        if let Some(index) = self.due_cancel() {
            return self.send_cancel(index);
        }
        let due = self.due_update()?;
        let (sequence, request) = (due.sequence, due.request.clone());
        self.sent = sequence;
        Some(request)
    }

    fn unsent(&self) -> Option<&Update> {
        let first = self
            .updates
            .partition_point(|update| update.sequence <= self.sent);
        self.updates.get(first)
    }

    /// The server takes no more than `window` unfinished updates.
    fn due_update(&self) -> Option<&Update> {
        self.unsent()
            .filter(|update| update.sequence - self.freed <= self.window)
    }

    /// A cancel follows the update that it means, but waits for no other.
    fn due_cancel(&self) -> Option<usize> {
        self.cancels.iter().position(|cancel| {
            !cancel.sent && (cancel.target <= self.sent || cancel.target > self.tail)
        })
    }

    fn send_cancel(&mut self, index: usize) -> Option<Request> {
        let cancel = self.cancels.get_mut(index)?;
        cancel.sent = true;
        let (sequence, target) = (cancel.sequence, cancel.target);
        if target > self.tail {
            // Nothing to cancel that this stream knows of, so nothing to repeat.
            self.cancels.remove(index);
        }
        Some(Request::Cancel(v1::SolveCancel { sequence }))
    }

    /// Takes an answer of the server and gives what the user shall see.
    ///
    /// # Errors
    /// [`ClientError::ResultsLost`].
    pub(super) fn take(&mut self, event: Event) -> Result<Vec<Event>, ClientError> {
        match event {
            Event::Increment(increment) => Ok(self
                .result(increment)?
                .map_or_else(Vec::new, |one| vec![one])),
            Event::Rejected { sequence, refusal } => Ok(self.rejection(sequence, refusal)),
            Event::Iteration(_)
            | Event::Heartbeat(_)
            | Event::ConnectionLost { .. }
            | Event::Reconnected { .. } => Ok(vec![event]),
        }
    }

    fn result(&mut self, increment: Box<Increment>) -> Result<Option<Event>, ClientError> {
        let (event, next) = (increment.event, self.seen + 1);
        if event < next {
            return Ok(None);
        }
        if self.contiguous && event != next {
            let (first, last) = (next, event - 1);
            return Err(ClientError::ResultsLost { first, last });
        }
        self.contiguous = true;
        self.seen = event;
        if increment.last {
            self.finish(increment.sequence);
        }
        Ok(Some(Event::Increment(increment)))
    }

    fn finish(&mut self, sequence: i64) {
        self.finished = self.finished.max(sequence);
        self.freed = self.freed.max(sequence);
        self.updates.retain(|update| update.sequence > sequence);
        self.cancels.retain(|cancel| cancel.target > sequence);
    }

    /// A rejected update takes those after it with it: the server answers each
    /// with a gap of its own, possibly on a connection that is gone by then, so
    /// they are answered here.
    fn rejection(&mut self, sequence: i64, refusal: Box<Refusal>) -> Vec<Event> {
        if let Some(at) = self.doomed.iter().position(|doomed| *doomed == sequence) {
            self.doomed.remove(at);
            return Vec::new();
        }
        let mut events = vec![Event::Rejected { sequence, refusal }];
        if sequence <= self.finished || sequence > self.tail {
            return events;
        }
        let first = self
            .updates
            .partition_point(|update| update.sequence < sequence);
        let later = self.updates.split_off(first).into_iter();
        for update in later.filter(|update| update.sequence > sequence) {
            if update.sequence <= self.sent {
                self.doomed.push_back(update.sequence);
            }
            events.push(gap(update.sequence, sequence));
        }
        self.tail = sequence - 1;
        self.sent = self.sent.min(self.tail);
        self.cancels.retain(|cancel| cancel.target < sequence);
        events
    }

    /// Starts on a new connection: what the server has not accepted goes again.
    ///
    /// # Errors
    /// [`ClientError::Protocol`] when the session is not the one that it was.
    pub(super) fn resume(&mut self, opened: &v1::StreamOpened) -> Result<(), ClientError> {
        if opened.last_event < self.seen {
            let (now, before) = (opened.last_event, self.seen);
            let message = format!("the session has {now} results and had {before}");
            return Err(ClientError::Protocol(message));
        }
        let (accepted, finished) = progress(opened);
        self.contiguous = true;
        self.sent = accepted.min(self.tail);
        self.freed = self.freed.max(finished);
        self.window = window(opened);
        self.doomed.clear();
        self.cancels.retain(|cancel| cancel.target > finished);
        for cancel in &mut self.cancels {
            // What runs now may be another step than the one that was meant.
            cancel.sequence = cancel.target;
            cancel.sent = false;
        }
        Ok(())
    }
}

/// Last accepted and last finished sequence.
fn progress(opened: &v1::StreamOpened) -> (i64, i64) {
    opened.session.as_ref().map_or((0, 0), |session| {
        (
            session.last_accepted_sequence,
            session.last_finished_sequence,
        )
    })
}

fn window(opened: &v1::StreamOpened) -> i64 {
    i64::from(opened.max_in_flight).max(1)
}

/// What the server answers to an update after a rejected one.
fn gap(sequence: i64, expected: i64) -> Event {
    let message = format!("update {sequence} leaves a gap: {expected} is expected");
    let refusal = Box::new(Refusal {
        code: Code::OutOfRange,
        reason: "SEQUENCE_GAP".to_owned(),
        message,
        metadata: BTreeMap::from([("expected".to_owned(), expected.to_string())]),
        violations: Vec::new(),
    });
    Event::Rejected { sequence, refusal }
}

#[cfg(test)]
mod tests;
