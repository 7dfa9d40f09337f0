//! One `Watch` stream: as a `Solve` stream that only reads.

use std::sync::Arc;

use signorini_proto::v1::{self as wire, solve_response, watch_response};
use tokio::sync::mpsc;
use tonic::Status;

use super::pump::{self, Attached, Sender};
use super::solve::unread_limit;
use crate::convert::{field, step};
use crate::door::access::Caller;
use crate::fault::Fault;
use crate::registry::Registry;
use crate::session::{OpenRequest, Role};

/// Serves a watcher in the background.
pub(crate) fn open(
    registry: &Arc<Registry>,
    request: wire::WatchRequest,
    caller: Caller,
) -> mpsc::Receiver<Result<wire::WatchResponse, Status>> {
    let span = tracing::info_span!("watch");
    pump::spawn(registry, span, |registry, sender| {
        serve(registry, request, sender, caller)
    })
}

async fn serve(
    registry: Arc<Registry>,
    request: wire::WatchRequest,
    sender: Sender<wire::WatchResponse>,
    caller: Caller,
) -> Result<(), Fault> {
    let handle = registry.get(&caller, &request.name).await?;
    let mut attachment = handle.attach(open_request(&request)?).await?;
    let attached = Attached::new(handle, attachment.number);
    let (pace, metrics) = (registry.pace(), registry.metrics());
    let pumping = pump::run(&mut attachment, &sender, pace, metrics, response);
    let ended = tokio::select! {
        ended = pumping => ended,
        () = caller.revoked() => Err(Fault::Unauthenticated),
    };
    attached.leave().await;
    ended
}

fn open_request(request: &wire::WatchRequest) -> Result<OpenRequest, Fault> {
    let until = wire::WatchEnd::try_from(request.until)
        .map_err(|_| Fault::unsupported("until", format!("number {}", request.until)))?;
    let interval = step::duration(request.iteration_interval.as_ref(), "iteration_interval")?;
    Ok(OpenRequest {
        last_seen_event: request.last_seen_event,
        fields: field::names(&request.fields, "fields")?,
        encoding: field::encoding(request.element_type)?,
        max_unread_bytes: unread_limit(request.max_unread_bytes, "max_unread_bytes")?,
        iteration_interval: interval.unwrap_or_default(),
        role: Role::Watcher { until },
    })
}

/// What a watcher sees of a message.
fn response(message: solve_response::Message) -> Option<wire::WatchResponse> {
    use watch_response::Message;
    let message = match message {
        solve_response::Message::Opened(opened) => Message::Opened(opened),
        solve_response::Message::Iteration(iteration) => Message::Iteration(iteration),
        solve_response::Message::StepFinished(finished) => Message::StepFinished(finished),
        solve_response::Message::Field(chunk) => Message::Field(chunk),
        solve_response::Message::Heartbeat(heartbeat) => Message::Heartbeat(heartbeat),
        // Between the session and its writer.
        solve_response::Message::UpdateRejected(_) => return None,
    };
    Some(wire::WatchResponse {
        message: Some(message),
    })
}
