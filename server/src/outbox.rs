//! Between a session and the reader of its stream: the only place where the two
//! speeds meet.
//!
//! Results are lossless and counted in bytes; when too many are unread the
//! session starts no further increment, but the one that runs never waits.
//! Iterations are latest-wins: a newer one replaces an unread one and counts it
//! as skipped. Nothing here blocks a solver thread for longer than a push.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use prost::Message as _;
use signorini_proto::v1::{self as wire, solve_response::Message};
use tokio::sync::Notify;
use tokio::time::{Instant, sleep_until};

use crate::fault::Fault;
use crate::metrics::Metrics;

/// How a stream ends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum End {
    /// Every update is answered.
    Done,
    /// With a status.
    Fault(Fault),
}

#[derive(Default)]
struct State {
    results: VecDeque<wire::SolveResponse>,
    unread_bytes: u64,
    iteration: Option<wire::IterationStatistics>,
    skipped: i64,
    end: Option<End>,
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
    drained: Notify,
    /// As `drained`, for whoever waits for room.
    read: Notify,
    limit_bytes: u64,
    metrics: Arc<Metrics>,
}

impl Outbox {
    /// An empty outbox whose session waits above `limit_bytes` unread.
    pub(crate) fn new(limit_bytes: u64, metrics: &Arc<Metrics>) -> Arc<Self> {
        Arc::new(Self {
            state: Mutex::default(),
            filled: Notify::new(),
            drained: Notify::new(),
            read: Notify::new(),
            limit_bytes,
            metrics: Arc::clone(metrics),
        })
    }

    /// Queues a message that must arrive, behind the newest iteration.
    pub(crate) fn push(&self, message: Message) {
        let mut state = self.lock();
        if let Some(iteration) = state.iteration.take() {
            enqueue(&mut state, Message::Iteration(iteration));
        }
        enqueue(&mut state, message);
        drop(state);
        self.filled.notify_one();
    }

    /// Replaces the newest iteration.
    pub(crate) fn iteration(&self, sequence: i64, report: wire::IterationReport) {
        let mut state = self.lock();
        if state.iteration.is_some() {
            state.skipped += 1;
            self.metrics.coalesced(1);
        }
        state.iteration = Some(wire::IterationStatistics {
            sequence,
            report: Some(report),
            skipped_count: state.skipped,
        });
        drop(state);
        self.filled.notify_one();
    }

    /// Ends the stream behind what is queued; the first end stays.
    pub(crate) fn end(&self, end: End) {
        self.lock().end.get_or_insert(end);
        self.filled.notify_one();
    }

    /// Whether a further increment may start.
    pub(crate) fn has_room(&self) -> bool {
        self.lock().unread_bytes <= self.limit_bytes
    }

    /// Returns when a further increment may start; for one task at a time.
    pub(crate) async fn room(&self) {
        while !self.has_room() {
            self.read.notified().await;
        }
    }

    /// Returns when messages were read since the last call.
    pub(crate) async fn drained(&self) {
        self.drained.notified().await;
    }

    /// The next thing for the reader: results first, iterations not before
    /// `iterations_from`, silence after `heartbeat`.
    pub(crate) async fn next(&self, iterations_from: Instant, heartbeat: Duration) -> Next {
        let silent_at = Instant::now() + heartbeat;
        loop {
            if let Some(next) = self.take(iterations_from) {
                return next;
            }
            let now = Instant::now();
            if now >= silent_at {
                return Next::Silence;
            }
            let wake_at = match iterations_from > now {
                true => iterations_from.min(silent_at),
                false => silent_at,
            };
            tokio::select! {
                () = self.filled.notified() => {}
                () = sleep_until(wake_at) => {}
            }
        }
    }

    fn take(&self, iterations_from: Instant) -> Option<Next> {
        let mut state = self.lock();
        if let Some(message) = state.results.pop_front() {
            state.unread_bytes = state.unread_bytes.saturating_sub(size(&message));
            drop(state);
            self.drained.notify_one();
            self.read.notify_one();
            return Some(Next::Message(Box::new(message)));
        }
        if let Some(end) = state.end.clone() {
            return Some(Next::End(end));
        }
        if Instant::now() < iterations_from {
            return None;
        }
        let iteration = state.iteration.take()?;
        state.skipped = 0;
        Some(Next::Message(Box::new(response(Message::Iteration(
            iteration,
        )))))
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // No code of others runs under the lock, so a poisoned state is whole.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn enqueue(state: &mut State, message: Message) {
    if matches!(message, Message::Iteration(_)) {
        state.skipped = 0;
    }
    let message = response(message);
    state.unread_bytes += size(&message);
    state.results.push_back(message);
}

fn response(message: Message) -> wire::SolveResponse {
    wire::SolveResponse {
        message: Some(message),
    }
}

fn size(message: &wire::SolveResponse) -> u64 {
    message.encoded_len() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOUR: Duration = Duration::from_secs(3600);

    fn outbox(limit: u64) -> Arc<Outbox> {
        Outbox::new(limit, &Metrics::new().unwrap())
    }

    fn heartbeat(sequence: i64) -> Message {
        Message::Heartbeat(wire::Heartbeat {
            running_sequence: sequence,
            ..Default::default()
        })
    }

    async fn next(outbox: &Outbox) -> Next {
        outbox.next(Instant::now(), HOUR).await
    }

    fn message(message: Message) -> Next {
        Next::Message(Box::new(response(message)))
    }

    #[tokio::test]
    async fn newest_iteration_wins_and_the_others_are_counted() {
        let outbox = outbox(1000);
        for krylov_iterations in 1..=5 {
            outbox.iteration(
                3,
                wire::IterationReport {
                    krylov_iterations,
                    ..Default::default()
                },
            );
        }
        let Next::Message(response) = next(&outbox).await else {
            panic!("a message is due");
        };
        let Some(Message::Iteration(newest)) = response.message else {
            panic!("an iteration is due");
        };
        assert_eq!((newest.skipped_count, newest.sequence), (4, 3));
        assert_eq!(newest.report.unwrap().krylov_iterations, 5);
    }

    #[tokio::test]
    async fn results_come_in_order_behind_the_last_iteration_and_before_the_end() {
        let outbox = outbox(1000);
        outbox.iteration(1, wire::IterationReport::default());
        outbox.push(heartbeat(1));
        outbox.push(heartbeat(2));
        outbox.end(End::Done);
        outbox.end(End::Fault(Fault::Internal));
        assert!(matches!(next(&outbox).await, Next::Message(_)));
        assert_eq!(next(&outbox).await, message(heartbeat(1)));
        assert_eq!(next(&outbox).await, message(heartbeat(2)));
        assert_eq!(next(&outbox).await, Next::End(End::Done));
    }

    #[tokio::test]
    async fn unread_bytes_close_the_room_until_they_are_read() {
        let outbox = outbox(4);
        outbox.push(heartbeat(1000));
        assert!(!outbox.has_room());
        assert_eq!(next(&outbox).await, message(heartbeat(1000)));
        outbox.drained().await;
        outbox.room().await;
        assert!(outbox.has_room());
    }

    #[tokio::test]
    async fn iterations_keep_their_distance_and_silence_is_told() {
        let outbox = outbox(1000);
        outbox.iteration(1, wire::IterationReport::default());
        let from = Instant::now() + Duration::from_millis(20);
        assert!(matches!(outbox.next(from, HOUR).await, Next::Message(_)));
        assert!(Instant::now() >= from);
        assert_eq!(
            outbox.next(from, Duration::from_millis(1)).await,
            Next::Silence
        );
    }
}
