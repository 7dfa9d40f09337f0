//! Between a session and the reader of one of its streams: the only place where
//! the two speeds meet.
//!
//! Results are lossless and counted in bytes: when too many are unread the
//! session queues no further one. A result is cut into messages only as they
//! are read, so that waiting costs no copy of its fields. Iterations are
//! latest-wins and come from the session's [`Iterations`](crate::session::Iterations).

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use signorini::report::FieldName;
use signorini_proto::v1::{self as wire, solve_response::Message};
use tokio::sync::Notify;
use tokio::time::{Instant, sleep_until};

use crate::convert::field::Encoding;
use crate::fault::Fault;
use crate::session::{IterationReader, KeptResult, Newest, messages};

/// Unread answers other than results above which a stream's messages are not read.
const MOST_ANSWERS: usize = 256;

/// How a stream ends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum End {
    /// Every update is answered.
    Done,
    /// With a status.
    Fault(Fault),
}

/// How a reader wants its fields.
#[derive(Clone, Debug)]
pub(crate) struct Wanted {
    pub(crate) fields: Vec<FieldName>,
    pub(crate) encoding: Encoding,
}

enum Item {
    Answer(Box<Message>),
    /// With the last iteration before it, for a result that was just made.
    Result(Arc<KeptResult>, Option<Newest>),
}

type Chunks = Box<dyn Iterator<Item = wire::FieldChunk> + Send>;

#[derive(Default)]
struct State {
    waiting: VecDeque<Item>,
    /// The rest of the result that is being read.
    finished: Option<wire::StepFinished>,
    chunks: Option<Chunks>,
    /// Event of the newest result that was read.
    read_event: i64,
    unread_bytes: u64,
    answers: usize,
    /// The session waits for room.
    is_awaited: bool,
    end: Option<End>,
}

impl State {
    fn was_read(&mut self, bytes: usize) {
        self.unread_bytes = self.unread_bytes.saturating_sub(bytes as u64);
    }
}

/// What the reader does next.
#[derive(Debug, PartialEq)]
pub(crate) enum Next {
    Message(Box<wire::SolveResponse>),
    End(End),
    /// Nothing came for the time of a heartbeat.
    Silence,
}

/// The outbox of one stream.
pub(crate) struct Outbox {
    state: Mutex<State>,
    filled: Notify,
    /// Fewer answers are unread.
    read: Notify,
    /// Wakes the session when there is room again.
    room: Arc<Notify>,
    wanted: Wanted,
    limit_bytes: u64,
}

impl Outbox {
    /// An empty outbox whose session waits above `limit_bytes` unread, until `room`.
    pub(crate) fn new(limit_bytes: u64, wanted: Wanted, room: &Arc<Notify>) -> Arc<Self> {
        Arc::new(Self {
            state: Mutex::default(),
            filled: Notify::new(),
            read: Notify::new(),
            room: Arc::clone(room),
            wanted,
            limit_bytes,
        })
    }

    /// Fields that come with each result.
    pub(crate) fn fields(&self) -> &[FieldName] {
        &self.wanted.fields
    }

    /// Queues a message that must arrive.
    pub(crate) fn push(&self, message: Message) {
        let mut state = self.lock();
        state.unread_bytes += message.encoded_len() as u64;
        state.answers += 1;
        state.waiting.push_back(Item::Answer(Box::new(message)));
        drop(state);
        self.filled.notify_one();
    }

    /// Queues a result, behind the last iteration before it.
    pub(crate) fn result(&self, result: &Arc<KeptResult>, iteration: Option<Newest>) {
        let mut state = self.lock();
        state.unread_bytes += self.bytes(result);
        let item = Item::Result(Arc::clone(result), iteration);
        state.waiting.push_back(item);
        drop(state);
        self.filled.notify_one();
    }

    /// Ends the stream behind what is queued; the first end stays.
    pub(crate) fn end(&self, end: End) {
        self.lock().end.get_or_insert(end);
        self.filled.notify_one();
    }

    /// Whether a further result may be queued; if not, the session is woken when
    /// one may.
    pub(crate) fn has_room(&self) -> bool {
        let mut state = self.lock();
        let has_room = state.unread_bytes <= self.limit_bytes;
        state.is_awaited |= !has_room;
        has_room
    }

    /// Returns when a message of the client, which may need an answer, may be read.
    pub(crate) async fn answerable(&self) {
        while self.lock().answers > MOST_ANSWERS {
            self.read.notified().await;
        }
    }

    /// The next thing for the reader: results and answers first, silence after
    /// `heartbeat`.
    pub(crate) async fn next(&self, iterations: &mut IterationReader, heartbeat: Duration) -> Next {
        let silent_at = Instant::now() + heartbeat;
        loop {
            if let Some(next) = self.take(iterations) {
                return next;
            }
            tokio::select! {
                () = self.filled.notified() => {}
                () = iterations.changed() => {}
                () = sleep_until(silent_at) => return Next::Silence,
            }
        }
    }

    fn take(&self, iterations: &mut IterationReader) -> Option<Next> {
        let mut state = self.lock();
        if let Some(message) = self
            .rest(&mut state)
            .or_else(|| self.begin(&mut state, iterations))
        {
            let wakes = state.is_awaited && state.unread_bytes <= self.limit_bytes;
            state.is_awaited &= !wakes;
            drop(state);
            if wakes {
                self.room.notify_one();
            }
            return Some(next(message));
        }
        if let Some(end) = state.end.clone() {
            return Some(Next::End(end));
        }
        // Nothing is queued: sizes that were estimated leave no remainder.
        state.unread_bytes = 0;
        let newest = iterations.take(state.read_event)?;
        Some(next(Message::Iteration(newest)))
    }

    /// What is left of the result that is being read.
    fn rest(&self, state: &mut State) -> Option<Message> {
        if let Some(finished) = state.finished.take() {
            state.read_event = state.read_event.max(finished.event);
            let message = Message::StepFinished(finished);
            state.was_read(message.encoded_len());
            return Some(message);
        }
        let Some(chunk) = state.chunks.as_mut()?.next() else {
            state.chunks = None;
            return None;
        };
        state.was_read(chunk.data.len());
        Some(Message::Field(chunk))
    }

    /// The first message of what is queued next.
    fn begin(&self, state: &mut State, iterations: &mut IterationReader) -> Option<Message> {
        match state.waiting.pop_front()? {
            Item::Answer(message) => {
                state.was_read(message.encoded_len());
                state.answers -= 1;
                self.read.notify_one();
                Some(*message)
            }
            Item::Result(result, iteration) => {
                let Wanted { fields, encoding } = &self.wanted;
                let (finished, chunks) = messages(&result, fields, *encoding);
                state.finished = Some(finished);
                state.chunks = Some(Box::new(chunks));
                match iteration.and_then(|newest| iterations.pass(newest)) {
                    Some(newest) => Some(Message::Iteration(newest)),
                    None => self.rest(state),
                }
            }
        }
    }

    /// Bytes of a result as this reader gets it.
    fn bytes(&self, result: &KeptResult) -> u64 {
        let Wanted { fields, encoding } = &self.wanted;
        let wanted = result
            .fields
            .iter()
            .filter(|one| fields.contains(&one.name));
        let fields: u64 = wanted.map(|field| field.encoded_bytes(*encoding)).sum();
        result.report.bytes() + fields
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // No code of others runs under the lock, so a poisoned state is whole.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn next(message: Message) -> Next {
    Next::Message(Box::new(wire::SolveResponse {
        message: Some(message),
    }))
}

#[cfg(test)]
mod tests;
