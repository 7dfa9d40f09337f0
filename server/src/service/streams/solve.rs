//! One `Solve` stream: a reader that turns messages into commands and a pump
//! that empties the outbox, in tasks of their own, so that neither waits for
//! the other.

use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use prost::Message as _;
use signorini_proto::v1::{self as wire, solve_request};
use tokio::sync::mpsc;
use tokio::time::Instant;
use tokio_stream::{Stream, StreamExt};
use tonic::{Status, Streaming};
use tracing::Instrument;

use super::pump::{self, Attached, Sender};
use crate::convert::{field, step};
use crate::door::access::{Caller, Who};
use crate::door::client_key::ClientKey;
use crate::door::transport;
use crate::fault::Fault;
use crate::fleet::Wish;
use crate::registry::Registry;
use crate::results::outbox::{Outbox, StreamEnd};
use crate::session::{Command, Handle, OnDisconnect, OpenRequest, Role};

const UNREAD_DEFAULT: i64 = 64 << 20;
const UNREAD_LEAST: i64 = 1 << 20;
const UNREAD_MOST: i64 = 1 << 30;

/// Time in which a stream has to say which session it is for.
const FIRST_MESSAGE: Duration = Duration::from_secs(10);

/// What the transport tells about a stream.
pub(crate) struct Call {
    pub(crate) caller: Caller,
    pub(crate) client: ClientKey,
    /// For the lines of what it changes beside the updates.
    pub(crate) who: Who,
    /// Time that the client gives the whole stream.
    pub(crate) timeout: Option<Duration>,
}

/// Serves a stream in the background; returns before anything was read.
pub(crate) fn open(
    registry: &Arc<Registry>,
    inbound: Streaming<wire::SolveRequest>,
    call: Call,
) -> mpsc::Receiver<Result<wire::SolveResponse, Status>> {
    let span = tracing::info_span!("solve");
    pump::spawn(registry, span, |registry, sender| {
        serve(registry, inbound, sender, call)
    })
}

async fn serve(
    registry: Arc<Registry>,
    mut inbound: Streaming<wire::SolveRequest>,
    sender: Sender<wire::SolveResponse>,
    call: Call,
) -> Result<(), Fault> {
    let deadline = call
        .timeout
        .and_then(|time| Instant::now().checked_add(time));
    let (name, request) = first_message(&mut inbound, call.client, deadline).await?;
    let handle = registry.get_for(&call.caller, &name, Wish::Drive).await?;
    let mut attachment = handle.attach(request).await?;
    let (number, outbox) = (attachment.number, Arc::clone(&attachment.outbox));
    let reading = read(handle.clone(), (number, call.who), outbox, inbound);
    let _reader = Aborted(tokio::spawn(reading.in_current_span()));
    let attached = Attached::new(handle, number);
    let (pace, metrics) = (registry.pace(), registry.metrics());
    let convert = |message| {
        let message = Some(message);
        Some(wire::SolveResponse { message })
    };
    let pumping = pump::run(&mut attachment, &sender, pace, metrics, convert);
    let ended = tokio::select! {
        ended = pumping => ended,
        () = passed(deadline) => Err(Fault::StreamDeadline),
        () = call.caller.revoked() => Err(Fault::Unauthenticated),
    };
    attached.leave().await;
    ended
}

/// A task that ends with the stream.
struct Aborted(tokio::task::JoinHandle<()>);

impl Drop for Aborted {
    fn drop(&mut self) {
        self.0.abort();
    }
}

async fn passed(deadline: Option<Instant>) {
    match deadline {
        Some(deadline) => tokio::time::sleep_until(deadline).await,
        None => std::future::pending().await,
    }
}

async fn first_message(
    inbound: &mut Streaming<wire::SolveRequest>,
    client: ClientKey,
    deadline: Option<Instant>,
) -> Result<(String, OpenRequest), Fault> {
    let missing = || Fault::request("open", "must be the first message");
    let first = tokio::time::timeout(FIRST_MESSAGE, inbound.message()).await;
    let late = |_| Fault::request("open", "did not come within 10 seconds");
    let first = match first.map_err(late)? {
        Ok(first) => first.ok_or_else(missing)?,
        Err(status) => return Err(transport::fault_of_stream(&status).unwrap_or_else(missing)),
    };
    let Some(solve_request::Message::Open(open)) = first.message else {
        return Err(missing());
    };
    let role = Role::Writer {
        client,
        on_disconnect: on_disconnect(&open)?,
        deadline,
    };
    Ok((open.session.clone(), open_request(&open, role)?))
}

fn on_disconnect(open: &wire::SolveOpen) -> Result<OnDisconnect, Fault> {
    let number = open.on_disconnect;
    let policy = wire::DisconnectPolicy::try_from(number)
        .map_err(|_| Fault::unsupported("open.on_disconnect", format!("number {number}")))?;
    let grace = step::duration(open.disconnect_grace.as_ref(), "open.disconnect_grace")?;
    Ok(OnDisconnect {
        policy,
        grace: grace.unwrap_or_default(),
    })
}

fn open_request(open: &wire::SolveOpen, role: Role) -> Result<OpenRequest, Fault> {
    let interval = open.iteration_interval.as_ref();
    let interval = step::duration(interval, "open.iteration_interval")?;
    Ok(OpenRequest {
        last_seen_event: open.last_seen_event,
        fields: field::names(&open.fields, "open.fields")?,
        encoding: field::encoding(open.element_type)?,
        max_unread_bytes: unread_limit(open.max_unread_bytes, "open.max_unread_bytes")?,
        iteration_interval: interval.unwrap_or_default(),
        role,
    })
}

/// The limit that a reader asks for; 0 is the default.
pub(super) fn unread_limit(bytes: i64, path: &str) -> Result<u64, Fault> {
    match bytes {
        0 => Ok(UNREAD_DEFAULT.unsigned_abs()),
        bytes if (UNREAD_LEAST..=UNREAD_MOST).contains(&bytes) => Ok(bytes.unsigned_abs()),
        _ => {
            let range = format!("must lie between {UNREAD_LEAST} and {UNREAD_MOST}");
            Err(Fault::request(path, range))
        }
    }
}

/// Reads until the client half-closes or leaves; waits while too many answers
/// are unread, because every message may need one.
async fn read(
    handle: Handle,
    (writer, who): (u64, Who),
    outbox: Arc<Outbox>,
    mut inbound: impl Stream<Item = Result<wire::SolveRequest, Status>> + Unpin,
) {
    loop {
        handle.handled().await;
        outbox.answerable().await;
        match inbound.next().await.transpose() {
            Ok(Some(request)) => match command(writer, request) {
                Ok(command) => {
                    if matches!(command, Command::CancelFrom(..)) {
                        who.did("SessionService/Solve: cancel", "Ok");
                    }
                    handle.send(command).await;
                }
                Err(fault) => return outbox.end(StreamEnd::Fault(fault)),
            },
            Ok(None) => return handle.send(Command::HalfClose(writer)).await,
            Err(status) => {
                // The connection broke or a message was no message; the pump
                // notices the first, this ends the second.
                tracing::debug!(status = status.to_string(), "stream ended by its client");
                let broken = || Fault::request("solve", "the stream broke");
                let fault = transport::fault_of_stream(&status).unwrap_or_else(broken);
                return outbox.end(StreamEnd::Fault(fault));
            }
        }
    }
}

fn command(writer: u64, request: wire::SolveRequest) -> Result<Command, Fault> {
    use solve_request::Message;
    // Made again, because the codec decodes before anybody sees the bytes: the same
    // message, but for fields that this version does not know.
    let encoded = Bytes::from(request.encode_to_vec());
    let (sequence, update) = match request.message {
        Some(Message::LoadStep(update)) => (update.sequence, step::load_step(&update, encoded)),
        Some(Message::ObstacleUpdate(update)) => {
            (update.sequence, step::obstacle_update(update, encoded))
        }
        Some(Message::Cancel(cancel)) => return Ok(Command::CancelFrom(writer, cancel.sequence)),
        Some(Message::Open(_)) => {
            return Err(Fault::request("open", "must be the first message only"));
        }
        None => {
            return Err(Fault::unsupported(
                "solve",
                "a message that this version does not know",
            ));
        }
    };
    Ok(match update {
        Ok(update) => Command::Update(writer, Box::new(update)),
        Err(fault) => Command::Reject(writer, sequence, fault),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn update_of(request: wire::SolveRequest) -> Box<step::Update> {
        match command(7, request) {
            Ok(Command::Update(7, update)) => update,
            _ => panic!("an update is a command"),
        }
    }

    #[test]
    fn an_update_reaches_its_session_with_the_message_that_brought_it() {
        let obstacles = vec![wire::ObstacleTarget {
            name: "ball".into(),
            translation: vec![0.0, 0.0, -0.1],
            ..Default::default()
        }];
        let moved = wire::ObstacleUpdate {
            sequence: 3,
            obstacles: obstacles.clone(),
            increments: Some(2),
            ..Default::default()
        };
        let loaded = wire::LoadStepUpdate {
            sequence: 4,
            step: Some(wire::LoadStep {
                load: Some(0.5),
                obstacles,
                ..Default::default()
            }),
            ..Default::default()
        };
        for message in [
            solve_request::Message::ObstacleUpdate(moved),
            solve_request::Message::LoadStep(loaded),
        ] {
            let message = Some(message);
            let request = wire::SolveRequest { message };
            let update = update_of(request.clone());
            assert_eq!(wire::SolveRequest::decode(update.encoded), Ok(request));
        }
    }
}
