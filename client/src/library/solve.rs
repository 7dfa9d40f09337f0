//! The stream that drives a session: updates out, typed events in.
//!
//! Reading and writing do not wait for each other, as the protocol asks: a
//! client that writes without reading would hold up its own results. [`Updates`]
//! sends and numbers the updates, at most as many unfinished ones as the server
//! holds; [`Events`] gives the answers, each result with its fields put together
//! from their chunks. An event that is not taken waits, and with it the stream;
//! iteration statistics are then skipped by the server.
//!
//! A connection that breaks is replaced: updates that are not finished are kept
//! and sent again where the server did not get them, results that it still keeps
//! come where the ones before them ended, each once. [`Event::ConnectionLost`]
//! and [`Event::Reconnected`] tell of it. What the service itself says ends the
//! stream as a typed error.

mod events;
mod incoming;
mod journal;
mod link;
mod options;
mod pump;
mod source;
mod user_channels;
mod watch;

use std::time::Duration;

use signorini_proto::v1;
use signorini_proto::v1::solve_request::Message as Request;
use tokio::sync::mpsc;

pub(crate) use events::Collector;
pub use events::{Event, Field, Increment};
pub use options::{Attach, PATIENCE, WatchOptions};
pub use watch::Watch;

use crate::library::breaks::again;
use crate::library::connect::{Client, answer};
use crate::library::error::ClientError;
use crate::library::session::resource;
use journal::{Journal, Order};
use pump::Pump;
use source::{Kind, Source, wire};
use user_channels::UserChannels;

/// Updates and events that may wait in the client.
const QUEUE: usize = 16;

/// An open stream.
#[derive(Debug)]
pub struct Solve {
    /// What the server said when the stream was opened.
    pub opened: v1::StreamOpened,
    /// Sends updates.
    pub updates: Updates,
    /// Receives answers.
    pub events: Events,
}

/// Sends updates, numbered without gaps.
#[derive(Debug)]
pub struct Updates {
    orders: mpsc::Sender<Order>,
    next: i64,
    max_wall_time: Option<prost_types::Duration>,
}

/// Asks for an end of steps; clones share the stream.
#[derive(Clone, Debug)]
pub struct Canceller(mpsc::Sender<Order>);

/// Receives answers in order.
#[derive(Debug)]
pub struct Events(mpsc::Receiver<Result<Event, ClientError>>);

impl Client {
    /// Opens the one stream of a session, by its identifier or name.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: `SESSION_NOT_FOUND`, `SESSION_BUSY` and others;
    /// [`ClientError::Silent`].
    pub async fn solve(&self, session: &str, attach: Attach) -> Result<Solve, ClientError> {
        let (orders, inbox) = mpsc::channel(QUEUE);
        let kind = Kind::Solve(attach);
        let (opened, events) = self.follow(session, kind, inbox).await?;
        let accepted = opened
            .session
            .as_ref()
            .map_or(0, |session| session.last_accepted_sequence);
        let updates = Updates {
            orders,
            next: accepted + 1,
            max_wall_time: None,
        };
        Ok(Solve {
            opened,
            updates,
            events,
        })
    }

    /// Opens a stream and starts the task that keeps it going.
    async fn follow(
        &self,
        session: &str,
        kind: Kind,
        orders: mpsc::Receiver<Order>,
    ) -> Result<(v1::StreamOpened, Events), ClientError> {
        let source = Source {
            client: self.of_session(session),
            session: resource(session),
            kind,
        };
        let last_seen = source.last_seen_event();
        let (opened, link) =
            again(|| async { answer(source.clone().attach(last_seen)).await }).await?;
        let journal = Journal::new(last_seen, &opened);
        let (sender, events) = mpsc::channel(QUEUE);
        let pump = Pump::new(source, journal, UserChannels::new(orders, sender));
        tokio::spawn(pump.run(link));
        Ok((opened, Events(events)))
    }
}

impl Updates {
    /// Sends a load step and gives its sequence.
    ///
    /// # Errors
    /// [`ClientError::Closed`].
    pub async fn load_step(&mut self, step: v1::LoadStep) -> Result<i64, ClientError> {
        let (step, max_wall_time) = (Some(step), self.max_wall_time);
        let update = v1::LoadStepUpdate {
            sequence: self.next,
            step,
            max_wall_time,
        };
        self.send(Request::LoadStep(update)).await
    }

    /// Moves obstacles at constant load and gives the sequence.
    ///
    /// # Errors
    /// [`ClientError::Closed`].
    pub async fn obstacle_update(
        &mut self,
        obstacles: Vec<v1::ObstacleTarget>,
    ) -> Result<i64, ClientError> {
        let (increments, max_wall_time) = (None, self.max_wall_time);
        let update = v1::ObstacleUpdate {
            sequence: self.next,
            obstacles,
            increments,
            max_wall_time,
        };
        self.send(Request::ObstacleUpdate(update)).await
    }

    async fn send(&mut self, request: Request) -> Result<i64, ClientError> {
        let sequence = self.next;
        let order = Order::Update(sequence, Box::new(request));
        let sent = self.orders.send(order).await;
        sent.map_err(|_| ClientError::Closed)?;
        self.next += 1;
        Ok(sequence)
    }

    /// Limits the wall time of each update that follows, counted from its start;
    /// one that takes longer ends with its last good state. `None`: no limit.
    ///
    /// # Errors
    /// [`ClientError::Protocol`] for a time that the wire cannot carry.
    pub fn set_max_wall_time(&mut self, limit: Option<Duration>) -> Result<(), ClientError> {
        self.max_wall_time = wire(limit, "the wall time")?;
        Ok(())
    }

    /// Takes a sequence back whose update was rejected: it is free again.
    pub fn rejected(&mut self, sequence: i64) {
        self.next = self.next.min(sequence);
    }

    /// A handle that cancels steps while this one is in use elsewhere.
    pub fn canceller(&self) -> Canceller {
        Canceller(self.orders.clone())
    }
}

impl Canceller {
    /// Cancels a step (0: the one that runs); its result comes as an event. Sent
    /// again after a break for as long as the step that it means is unfinished.
    ///
    /// # Errors
    /// [`ClientError::Closed`].
    pub async fn cancel(&self, sequence: i64) -> Result<(), ClientError> {
        let sent = self.0.send(Order::Cancel(sequence)).await;
        sent.map_err(|_| ClientError::Closed)
    }
}

impl Events {
    /// The next answer; `None` when the stream has ended.
    ///
    /// # Errors
    /// [`ClientError`]; none follows.
    pub async fn next(&mut self) -> Result<Option<Event>, ClientError> {
        self.0.recv().await.transpose()
    }
}
