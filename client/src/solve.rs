//! The stream that drives a session: updates out, typed events in.
//!
//! Reading and writing are separate tasks, as the protocol asks: a client that
//! writes without reading would hold up its own results. [`Updates`] sends and
//! numbers the updates; [`Events`] gives the answers, each result with its
//! fields put together from their chunks. An event that is not taken waits, and
//! with it the stream; iteration statistics are then skipped by the server.

mod events;

use std::time::Duration;

use signorini_proto::v1;
use signorini_proto::v1::solve_request::Message as Request;
use signorini_proto::v1::solve_response::Message as Response;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::Streaming;

pub use events::{Event, Field, Increment};

use crate::connect::Client;
use crate::error::ClientError;
use crate::mesh::missing;
use events::Collector;

/// Updates and events that may wait in the client.
const QUEUE: usize = 16;

/// How to attach to a session.
#[derive(Clone, Debug, Default)]
pub struct Attach {
    /// Results after this event that the server still keeps are sent again;
    /// `None`: none is.
    pub last_seen_event: Option<i64>,
    /// Fields wanted with each result; empty: those of the scene.
    pub fields: Vec<v1::FieldName>,
    /// At most one iteration event in this time; `None`: as fast as they are read.
    pub iteration_interval: Option<Duration>,
    /// What a broken connection means for the step that runs.
    pub on_disconnect: v1::DisconnectPolicy,
}

/// An open stream.
#[derive(Debug)]
pub struct Solve {
    /// What the server said when the stream was opened.
    pub opened: v1::Opened,
    /// Sends updates.
    pub updates: Updates,
    /// Receives answers.
    pub events: Events,
}

/// Sends updates, numbered without gaps.
#[derive(Debug)]
pub struct Updates {
    requests: mpsc::Sender<v1::SolveRequest>,
    next: i64,
}

/// Asks for an end of steps; clones share the stream.
#[derive(Clone, Debug)]
pub struct Canceller(mpsc::Sender<v1::SolveRequest>);

/// Receives answers in order.
#[derive(Debug)]
pub struct Events(mpsc::Receiver<Result<Event, ClientError>>);

impl Client {
    /// Opens the one stream of a session.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: `SESSION_NOT_FOUND`, `SESSION_BUSY` and others.
    pub async fn solve(&self, session: &str, attach: Attach) -> Result<Solve, ClientError> {
        let (requests, outgoing) = mpsc::channel(QUEUE);
        // Queued before the call: the server's answer waits for it.
        send(&requests, Request::Open(open(session, attach)?)).await?;
        let response = self.sessions().solve(ReceiverStream::new(outgoing)).await?;
        let mut incoming = response.into_inner();
        let first = incoming.message().await?.and_then(|first| first.message);
        let Some(Response::Opened(opened)) = first else {
            return Err(missing("the first message `opened`"));
        };
        let accepted = opened
            .session
            .as_ref()
            .map_or(0, |session| session.last_accepted_sequence);
        let (sender, events) = mpsc::channel(QUEUE);
        tokio::spawn(receive(incoming, sender));
        Ok(Solve {
            opened,
            updates: Updates {
                requests,
                next: accepted + 1,
            },
            events: Events(events),
        })
    }
}

fn open(session: &str, attach: Attach) -> Result<v1::Open, ClientError> {
    let interval = attach
        .iteration_interval
        .map(prost_types::Duration::try_from)
        .transpose();
    let interval = interval
        .map_err(|_| ClientError::Protocol("the iteration interval is too long".to_owned()))?;
    Ok(v1::Open {
        session: session.to_owned(),
        last_seen_event: attach.last_seen_event,
        fields: attach.fields.into_iter().map(i32::from).collect(),
        element_type: v1::ElementType::F64.into(),
        max_unread_bytes: 0,
        on_disconnect: attach.on_disconnect.into(),
        iteration_interval: interval,
    })
}

async fn send(
    requests: &mpsc::Sender<v1::SolveRequest>,
    message: Request,
) -> Result<(), ClientError> {
    let request = v1::SolveRequest {
        message: Some(message),
    };
    requests
        .send(request)
        .await
        .map_err(|_| ClientError::Closed)
}

/// Passes answers on until the stream ends or nobody listens.
async fn receive(
    mut incoming: Streaming<v1::SolveResponse>,
    events: mpsc::Sender<Result<Event, ClientError>>,
) {
    let mut collector = Collector::default();
    loop {
        let event = match incoming.message().await {
            Ok(None) => return,
            Ok(Some(response)) => collector.take(response).transpose(),
            Err(status) => Some(Err(status.into())),
        };
        let Some(event) = event else { continue };
        let failed = event.is_err();
        if events.send(event).await.is_err() || failed {
            return;
        }
    }
}

impl Updates {
    /// Sends a load step and gives its sequence.
    ///
    /// # Errors
    /// [`ClientError::Closed`].
    pub async fn load_step(&mut self, step: v1::LoadStep) -> Result<i64, ClientError> {
        let sequence = self.next;
        let (step, max_wall_time) = (Some(step), None);
        let update = v1::LoadStepUpdate {
            sequence,
            step,
            max_wall_time,
        };
        send(&self.requests, Request::LoadStep(update)).await?;
        self.next += 1;
        Ok(sequence)
    }

    /// Moves obstacles at constant load and gives the sequence.
    ///
    /// # Errors
    /// [`ClientError::Closed`].
    pub async fn obstacle_update(
        &mut self,
        obstacles: Vec<v1::ObstacleTarget>,
    ) -> Result<i64, ClientError> {
        let sequence = self.next;
        let (increments, max_wall_time) = (None, None);
        let update = v1::ObstacleUpdate {
            sequence,
            obstacles,
            increments,
            max_wall_time,
        };
        send(&self.requests, Request::ObstacleUpdate(update)).await?;
        self.next += 1;
        Ok(sequence)
    }

    /// Takes a sequence back whose update was rejected: it is free again.
    pub fn rejected(&mut self, sequence: i64) {
        self.next = self.next.min(sequence);
    }

    /// A handle that cancels steps while this one is in use elsewhere.
    pub fn canceller(&self) -> Canceller {
        Canceller(self.requests.clone())
    }
}

impl Canceller {
    /// Cancels a step (0: the one that runs); its result comes as an event.
    ///
    /// # Errors
    /// [`ClientError::Closed`].
    pub async fn cancel(&self, sequence: i64) -> Result<(), ClientError> {
        send(&self.0, Request::Cancel(v1::Cancel { sequence })).await
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
