//! Between a session and the reader of one of its streams: the only place where
//! the two speeds meet.
//!
//! Results are lossless and counted in bytes: when too many are unread the
//! session queues no further one. A result is cut into messages only as they
//! are read, so that waiting costs no copy of its fields; while it waits it keeps
//! all its fields in memory, so all of them count. Iterations are
//! latest-wins and come from the session's [`Iterations`](super::iterations::Iterations).

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use signorini::report::FieldName;
use signorini_proto::v1::{self as wire, solve_response::Message};
use tokio::sync::Notify;
use tokio::time::{Instant, sleep_until};

use super::iterations::{IterationReader, Newest};
use super::kept::{KeptResult, messages};
use crate::convert::field::Encoding;
use crate::fault::Fault;

/// Unread answers other than results above which a stream's messages are not read.
const MOST_ANSWERS: usize = 256;

/// How a stream of a session ends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum StreamEnd {
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
    /// Last field of that result.
    last_field: Option<i32>,
    /// Event of the newest result that was read.
    read_event: i64,
    waiting_bytes: u64,
    reading_bytes: u64,
    results: usize,
    answers: usize,
    /// The session waits for room.
    is_awaited: bool,
    /// It waits until nothing is unread.
    needs_empty: bool,
    end: Option<StreamEnd>,
}

impl State {
    /// Whether nothing of the result that is being read follows `chunk`.
    fn is_last(&self, chunk: &wire::FieldChunk) -> bool {
        chunk.last && self.last_field == Some(chunk.field)
    }

    fn unread_bytes(&self) -> u64 {
        self.waiting_bytes + self.reading_bytes
    }
}

impl Item {
    /// Bytes that it keeps in memory.
    fn bytes(&self) -> u64 {
        match self {
            Self::Answer(message) => message.encoded_len() as u64,
            Self::Result(result, _) => result.bytes(),
        }
    }
}

/// What the reader does next.
#[derive(Debug, PartialEq)]
pub(crate) enum Next {
    Message(Box<wire::SolveResponse>),
    End(StreamEnd),
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
    limit: Limit,
}

/// What may wait in an outbox before its session queues no further result.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limit {
    pub(crate) bytes: u64,
    pub(crate) results: usize,
}

impl Outbox {
    /// An empty outbox whose session waits above `limit`, until `room`.
    pub(crate) fn new(limit: Limit, wanted: Wanted, room: &Arc<Notify>) -> Arc<Self> {
        Arc::new(Self {
            state: Mutex::default(),
            filled: Notify::new(),
            read: Notify::new(),
            room: Arc::clone(room),
            wanted,
            limit,
        })
    }

    /// Fields that come with each result.
    pub(crate) fn fields(&self) -> &[FieldName] {
        &self.wanted.fields
    }

    /// Queues a message that must arrive.
    pub(crate) fn push(&self, message: Message) {
        self.queue(Item::Answer(Box::new(message)));
    }

    /// Queues a result, after the last iteration before it.
    pub(crate) fn result(&self, result: &Arc<KeptResult>, iteration: Option<Newest>) {
        self.queue(Item::Result(Arc::clone(result), iteration));
    }

    fn queue(&self, item: Item) {
        let mut state = self.lock();
        state.waiting_bytes += item.bytes();
        match &item {
            Item::Answer(_) => state.answers += 1,
            Item::Result(..) => state.results += 1,
        }
        state.waiting.push_back(item);
        drop(state);
        self.filled.notify_one();
    }

    /// Bytes that unread messages keep in memory.
    pub(crate) fn unread_bytes(&self) -> u64 {
        self.lock().unread_bytes()
    }

    /// Ends the stream after what is queued; the first end stays.
    pub(crate) fn end(&self, end: StreamEnd) {
        self.lock().end.get_or_insert(end);
        self.filled.notify_one();
    }

    /// Whether a further result may be queued; if not, the session is woken when
    /// one may.
    pub(crate) fn has_room(&self) -> bool {
        let mut state = self.lock();
        let has_room = self.fits(&state);
        state.is_awaited |= !has_room;
        has_room
    }

    /// Lets nothing more in before all is read, and wakes the session then: memory is
    /// lacking.
    pub(crate) fn await_empty(&self) {
        let mut state = self.lock();
        (state.is_awaited, state.needs_empty) = (true, true);
        let is_read = self.fits(&state);
        drop(state);
        if is_read {
            // It was read meanwhile.
            self.room.notify_one();
        }
    }

    fn fits(&self, state: &State) -> bool {
        if state.needs_empty {
            return state.unread_bytes() == 0;
        }
        state.unread_bytes() <= self.limit.bytes && state.results < self.limit.results
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
            let wakes = state.is_awaited && self.fits(&state);
            state.is_awaited &= !wakes;
            state.needs_empty &= !wakes;
            drop(state);
            if wakes {
                self.room.notify_one();
            }
            return Some(next(message));
        }
        if let Some(end) = state.end.clone() {
            return Some(Next::End(end));
        }
        let newest = iterations.take(state.read_event)?;
        Some(next(Message::Iteration(newest)))
    }

    /// What is left of the result that is being read.
    fn rest(&self, state: &mut State) -> Option<Message> {
        if let Some(finished) = state.finished.take() {
            state.read_event = state.read_event.max(finished.event);
            return Some(Message::StepFinished(finished));
        }
        let chunk = state.chunks.as_mut()?.next();
        if chunk.is_none() {
            state.chunks = None;
        }
        if chunk.as_ref().is_none_or(|chunk| state.is_last(chunk)) {
            state.reading_bytes = 0;
        }
        chunk.map(Message::Field)
    }

    /// The first message of what is queued next.
    fn begin(&self, state: &mut State, iterations: &mut IterationReader) -> Option<Message> {
        let item = state.waiting.pop_front()?;
        let bytes = item.bytes();
        state.waiting_bytes -= bytes;
        match item {
            Item::Answer(message) => {
                state.answers -= 1;
                self.read.notify_one();
                Some(*message)
            }
            Item::Result(result, iteration) => {
                let Wanted { fields, encoding } = &self.wanted;
                let (finished, chunks) = messages(&result, fields, *encoding);
                state.results -= 1;
                state.reading_bytes = if finished.fields.is_empty() { 0 } else { bytes };
                state.last_field = finished.fields.last().copied();
                state.finished = Some(finished);
                state.chunks = Some(Box::new(chunks));
                match iteration.and_then(|newest| iterations.pass(newest)) {
                    Some(newest) => Some(Message::Iteration(newest)),
                    None => self.rest(state),
                }
            }
        }
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
