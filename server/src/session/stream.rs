//! One `Solve` stream: a reader that turns messages into commands and a pump
//! that empties the outbox, in tasks of their own, so that neither waits for
//! the other.

use std::sync::Arc;
use std::time::Duration;

use signorini_proto::v1::{self as wire, solve_request, solve_response};
use tokio::sync::mpsc;
use tokio::task::AbortHandle;
use tokio::time::Instant;
use tokio_stream::{Stream, StreamExt};
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
    let attached = Attached {
        handle,
        writer: Some(writer),
        reader: reader.abort_handle(),
    };
    let ended = pump(&attachment, sender, heartbeat, interval).await;
    attached.leave().await;
    ended
}

/// A stream that writes to its session until it leaves or its task ends.
struct Attached {
    handle: Handle,
    /// `None` when it has left.
    writer: Option<u64>,
    reader: AbortHandle,
}

impl Attached {
    /// Detaches before the client hears of the end, so that it may come back at once.
    async fn leave(mut self) {
        self.reader.abort();
        if let Some(writer) = self.writer {
            self.handle.send(Command::Detach(writer)).await;
        }
        self.writer = None;
    }
}

impl Drop for Attached {
    fn drop(&mut self) {
        self.reader.abort();
        if let Some(writer) = self.writer {
            self.handle.post(Command::Detach(writer));
        }
    }
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

/// Reads until the client half-closes or leaves; waits while the outbox has no
/// room, because every message may fill it further.
async fn read(
    handle: Handle,
    writer: u64,
    outbox: Arc<Outbox>,
    mut inbound: impl Stream<Item = Result<wire::SolveRequest, Status>> + Unpin,
) {
    loop {
        handle.handled().await;
        outbox.room().await;
        match inbound.next().await.transpose() {
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

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::future::{Future, poll_fn};
    use std::pin::{Pin, pin};
    use std::task::Poll;

    use super::*;
    use crate::metrics::Metrics;

    async fn once(mut work: Pin<&mut impl Future<Output = ()>>) -> Poll<()> {
        poll_fn(|context| Poll::Ready(work.as_mut().poll(context))).await
    }

    /// Runs `work` until it waits for something that only the test gives.
    async fn until_it_waits(work: Pin<&mut impl Future<Output = ()>>) {
        assert!(once(work).await.is_pending());
    }

    fn answer_handled(commands: &mut mpsc::Receiver<Command>) {
        let Ok(Command::Handled(reply)) = commands.try_recv() else {
            panic!("the reader asks whether its commands are handled");
        };
        reply.send(()).unwrap();
    }

    #[tokio::test]
    async fn nothing_is_read_while_there_is_no_room() {
        let (handle, mut commands) = Handle::new("sessions/test");
        let outbox = Outbox::new(1, &Metrics::new().unwrap());
        outbox.push(solve_response::Message::Heartbeat(wire::Heartbeat {
            running_sequence: 1000,
            ..Default::default()
        }));
        let taken = Cell::new(0);
        let cancel = solve_request::Message::Cancel(wire::Cancel::default());
        let inbound = tokio_stream::iter(0..9).map(|_| {
            taken.set(taken.get() + 1);
            Ok(wire::SolveRequest {
                message: Some(cancel.clone()),
            })
        });
        let mut read = pin!(read(handle, 1, Arc::clone(&outbox), inbound));
        until_it_waits(read.as_mut()).await;
        answer_handled(&mut commands);
        until_it_waits(read.as_mut()).await;
        assert_eq!(taken.get(), 0);
        outbox.next(Instant::now(), Duration::from_secs(3600)).await;
        until_it_waits(read.as_mut()).await;
        // The second one waits until the first is handled.
        assert_eq!(taken.get(), 1);
        assert!(matches!(commands.try_recv(), Ok(Command::CancelFrom(1, 0))));
    }

    #[tokio::test]
    async fn a_stream_whose_task_dies_detaches_even_from_a_full_inbox() {
        let (handle, mut commands) = Handle::new("sessions/test");
        while let Poll::Ready(()) = once(pin!(handle.send(Command::CancelFrom(7, 0)))).await {}
        let reader = tokio::spawn(std::future::pending::<()>()).abort_handle();
        drop(Attached {
            handle,
            writer: Some(7),
            reader,
        });
        let mut last = None;
        while let Some(command) = commands.recv().await {
            last = Some(command);
        }
        assert!(matches!(last, Some(Command::Detach(7))));
    }
}
