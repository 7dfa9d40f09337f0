//! The pump of a stream: empties its outbox until that ends, the client leaves, or takes nothing for
//! too long: then the session is free for another stream, and what waited is given back.

use std::future::Future;
use std::sync::Arc;

use signorini_proto::v1::{self as wire, solve_response::Message};
use tokio::sync::mpsc;
use tokio::sync::mpsc::error::SendTimeoutError;
use tonic::Status;
use tracing::Instrument;

use crate::fault::Fault;
use crate::registry::{Pace, Registry};
use crate::results::outbox::{Next, StreamEnd};
use crate::session::{Attachment, Command, Handle};
use crate::watch::metrics::Metrics;

/// Messages on their way to the client.
pub(super) type Sender<T> = mpsc::Sender<Result<T, Status>>;

/// Runs `serve` of a stream in the background; what it fails with ends the stream.
pub(super) fn spawn<T, F>(
    registry: &Arc<Registry>,
    span: tracing::Span,
    serve: impl FnOnce(Arc<Registry>, Sender<T>) -> F,
) -> mpsc::Receiver<Result<T, Status>>
where
    T: Send + 'static,
    F: Future<Output = Result<(), Fault>> + Send + 'static,
{
    // One message: what is unread shall stay in the outbox, which counts it.
    let (sender, answers) = mpsc::channel(1);
    let (open, registry) = (registry.stream(), Arc::clone(registry));
    let serving = serve(Arc::clone(&registry), sender.clone());
    let run = async move {
        let _open = open;
        if let Err(fault) = serving.await {
            registry.refused(&fault);
            // The client may have left already; one that takes nothing loses its connection.
            let _left = sender.send(Err(fault.into())).await;
        }
    };
    tokio::spawn(run.instrument(span));
    answers
}

/// A stream that is attached to its session until it leaves or its task ends.
pub(super) struct Attached {
    handle: Handle,
    /// `None` when it has left.
    number: Option<u64>,
}

impl Attached {
    pub(super) fn new(handle: Handle, number: u64) -> Self {
        let number = Some(number);
        Self { handle, number }
    }

    /// Detaches before the client hears of the end, so that it may come back at once.
    pub(super) async fn leave(mut self) {
        if let Some(number) = self.number {
            self.handle.send(Command::Detach(number)).await;
        }
        self.number = None;
    }
}

impl Drop for Attached {
    fn drop(&mut self) {
        if let Some(number) = self.number {
            self.handle.post(Command::Detach(number));
        }
    }
}

/// Sends, through `convert`, until the outbox ends or the client leaves.
///
/// # Errors
/// Why the outbox has ended; `StreamUnread`.
pub(super) async fn run<T>(
    attachment: &mut Attachment,
    sender: &Sender<T>,
    pace: Pace,
    metrics: &Metrics,
    convert: impl Fn(Message) -> Option<T>,
) -> Result<(), Fault> {
    loop {
        let (outbox, iterations) = (&attachment.outbox, &mut attachment.iterations);
        let next = tokio::select! {
            next = outbox.next(iterations, pace.heartbeat) => next,
            () = sender.closed() => return Ok(()),
        };
        let message = match next {
            Next::Message(response) => response.message,
            Next::Silence => Some(beat(attachment)),
            Next::End(StreamEnd::Done) => return Ok(()),
            Next::End(StreamEnd::Fault(fault)) => return Err(fault),
        };
        if let Some(Message::Iteration(iteration)) = &message {
            metrics.coalesced(iteration.skipped_count.unsigned_abs());
        }
        let Some(message) = message.and_then(&convert) else {
            continue;
        };
        match sender.send_timeout(Ok(message), pace.unread).await {
            Ok(()) => {}
            Err(SendTimeoutError::Closed(_)) => return Ok(()),
            Err(SendTimeoutError::Timeout(_)) => {
                let seconds = pace.unread.as_secs();
                return Err(Fault::StreamUnread { seconds });
            }
        }
    }
}

fn beat(attachment: &Attachment) -> Message {
    let (state, running_sequence) = *attachment.pulse.borrow();
    Message::Heartbeat(wire::StreamHeartbeat {
        state: state.into(),
        running_sequence,
    })
}

#[cfg(test)]
mod tests {
    use std::future::poll_fn;
    use std::pin::pin;
    use std::task::Poll;

    use super::*;

    async fn is_ready(work: impl Future<Output = ()>) -> bool {
        let mut work = pin!(work);
        poll_fn(|context| Poll::Ready(work.as_mut().poll(context).is_ready())).await
    }

    #[tokio::test]
    async fn a_stream_whose_task_dies_detaches_even_from_a_full_inbox() {
        let (handle, mut commands) = Handle::new("sessions/test", &Arc::default());
        while is_ready(handle.send(Command::CancelFrom(7, 0))).await {}
        drop(Attached::new(handle, 7));
        let mut last = None;
        while let Some(command) = commands.recv().await {
            last = Some(command);
        }
        assert!(matches!(last, Some(Command::Detach(7))));
    }
}
