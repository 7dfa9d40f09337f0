//! One `Solve` stream: a reader that turns messages into commands and a pump
//! that empties the outbox, in tasks of their own, so that neither waits for
//! the other.

use std::sync::Arc;
use std::time::Duration;

use signorini_proto::v1::{self as wire, solve_request, solve_response};
use tokio::sync::mpsc;
use tokio::time::Instant;
use tonic::{Status, Streaming};
use tracing::Instrument;

use super::handle::{Attachment, Command, Handle, OpenRequest};
use crate::convert::{field, step};
use crate::fault::Fault;
use crate::outbox::{End, Next, Outbox};
use crate::registry::Registry;

const UNREAD_DEFAULT: i64 = 64 << 20;
const UNREAD_LEAST: i64 = 1 << 20;
const UNREAD_MOST: i64 = 1 << 30;

/// Messages on their way to the client.
pub(crate) type Answers = mpsc::Receiver<Result<wire::SolveResponse, Status>>;

/// Serves a stream in the background; returns before anything was read.
pub(crate) fn open(
    registry: Arc<Registry>,
    inbound: Streaming<wire::SolveRequest>,
    heartbeat: Duration,
) -> Answers {
    // One message: what is unread shall stay in the outbox, which counts it.
    let (sender, answers) = mpsc::channel(1);
    let span = tracing::info_span!("solve");
    let run = async move {
        if let Err(fault) = serve(&registry, inbound, &sender, heartbeat).await {
            registry.refused(&fault);
            // The client may have left already.
            let _left = sender.send(Err(fault.into())).await;
        }
    };
    tokio::spawn(run.instrument(span));
    answers
}

async fn serve(
    registry: &Registry,
    mut inbound: Streaming<wire::SolveRequest>,
    sender: &mpsc::Sender<Result<wire::SolveResponse, Status>>,
    heartbeat: Duration,
) -> Result<(), Fault> {
    let (name, request) = first_message(&mut inbound).await?;
    let interval = request.iteration_interval.unwrap_or_default();
    let handle = registry.get(&name)?;
    let attachment = handle.attach(request).await?;
    let (writer, outbox) = (attachment.writer, Arc::clone(&attachment.outbox));
    let reader = tokio::spawn(read(handle.clone(), writer, outbox, inbound).in_current_span());
    let ended = pump(&attachment, sender, heartbeat, interval).await;
    reader.abort();
    handle.send(Command::Detach(writer)).await;
    ended
}

async fn first_message(
    inbound: &mut Streaming<wire::SolveRequest>,
) -> Result<(String, OpenRequest), Fault> {
    let missing = || Fault::request("open", "must be the first message");
    let first = inbound.message().await.ok().flatten().ok_or_else(missing)?;
    let Some(solve_request::Message::Open(open)) = first.message else {
        return Err(missing());
    };
    Ok((open.session.clone(), open_request(&open)?))
}

fn open_request(open: &wire::Open) -> Result<OpenRequest, Fault> {
    let max_unread_bytes = match open.max_unread_bytes {
        0 => UNREAD_DEFAULT,
        bytes if (UNREAD_LEAST..=UNREAD_MOST).contains(&bytes) => bytes,
        _ => {
            let range = format!("must lie between {UNREAD_LEAST} and {UNREAD_MOST}");
            return Err(Fault::request("open.max_unread_bytes", range));
        }
    };
    Ok(OpenRequest {
        last_seen_event: open.last_seen_event,
        fields: field::names(&open.fields, "open.fields")?,
        encoding: field::encoding(open.element_type)?,
        max_unread_bytes: max_unread_bytes.unsigned_abs(),
        on_disconnect: open.on_disconnect(),
        iteration_interval: step::duration(
            open.iteration_interval.as_ref(),
            "open.iteration_interval",
        )?,
    })
}

/// Reads until the client half-closes or leaves.
async fn read(
    handle: Handle,
    writer: u64,
    outbox: Arc<Outbox>,
    mut inbound: Streaming<wire::SolveRequest>,
) {
    loop {
        match inbound.message().await {
            Ok(Some(request)) => match command(writer, request) {
                Ok(command) => handle.send(command).await,
                Err(fault) => return outbox.end(End::Fault(fault)),
            },
            Ok(None) => return handle.send(Command::HalfClose(writer)).await,
            Err(status) => {
                // The connection broke or a message was no message; the pump
                // notices the first, this ends the second.
                tracing::debug!(%status, "stream ended by its client");
                let fault = Fault::request("solve", "the stream broke");
                return outbox.end(End::Fault(fault));
            }
        }
    }
}

fn command(writer: u64, request: wire::SolveRequest) -> Result<Command, Fault> {
    use solve_request::Message;
    let (sequence, update) = match request.message {
        Some(Message::LoadStep(update)) => (update.sequence, step::load_step(&update)),
        Some(Message::ObstacleUpdate(update)) => (update.sequence, step::obstacle_update(update)),
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

/// Sends until the outbox ends or the client leaves.
async fn pump(
    attachment: &Attachment,
    sender: &mpsc::Sender<Result<wire::SolveResponse, Status>>,
    heartbeat: Duration,
    interval: Duration,
) -> Result<(), Fault> {
    let mut iterations_from = Instant::now();
    loop {
        let next = tokio::select! {
            next = attachment.outbox.next(iterations_from, heartbeat) => next,
            () = sender.closed() => return Ok(()),
        };
        let message = match next {
            Next::Message(message) => *message,
            Next::Silence => beat(attachment),
            Next::End(End::Done) => return Ok(()),
            Next::End(End::Fault(fault)) => return Err(fault),
        };
        if matches!(message.message, Some(solve_response::Message::Iteration(_))) {
            iterations_from = Instant::now() + interval;
        }
        if sender.send(Ok(message)).await.is_err() {
            return Ok(());
        }
    }
}

fn beat(attachment: &Attachment) -> wire::SolveResponse {
    let (state, running_sequence) = *attachment.pulse.borrow();
    let heartbeat = wire::Heartbeat {
        state: state.into(),
        running_sequence,
    };
    wire::SolveResponse {
        message: Some(solve_response::Message::Heartbeat(heartbeat)),
    }
}
