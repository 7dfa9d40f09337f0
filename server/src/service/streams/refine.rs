//! One `RefineMesh` stream: rounds as they come, then the refined mesh. The work ends with the call
//! and where the server shuts down.

use std::sync::Arc;
use std::time::Duration;

use signorini::adapted::Adapted;
use signorini::report::CancelToken;
use signorini_proto::v1::{self as wire, refine_mesh_response::Part};
use tokio::sync::mpsc;
use tokio::sync::mpsc::error::SendTimeoutError;
use tonic::Status;

use super::pump::{self, Sender};
use crate::convert::refinement;
use crate::convert::scene::take_accuracy;
use crate::fault::Fault;
use crate::registry::Registry;
use crate::registry::refining::{Asker, Told, begin, kept, planned};
use crate::session::Services;
use crate::uploads::store::Reservation;

/// How often a call without news looks whether the server shuts down.
const LOOK: Duration = Duration::from_millis(500);

/// Serves a call in the background.
pub(crate) fn open(
    registry: &Arc<Registry>,
    services: &Arc<Services>,
    request: wire::RefineMeshRequest,
    asker: Asker,
) -> mpsc::Receiver<Result<wire::RefineMeshResponse, Status>> {
    let span = tracing::info_span!("refine");
    let services = Arc::clone(services);
    pump::spawn(registry, span, |registry, sender| {
        serve((registry, services), request, asker, sender)
    })
}

async fn serve(
    (registry, services): (Arc<Registry>, Arc<Services>),
    request: wire::RefineMeshRequest,
    asker: Asker,
    sender: Sender<wire::RefineMeshResponse>,
) -> Result<(), Fault> {
    let mut scene = request
        .scene
        .ok_or_else(|| Fault::request("scene", "is required"))?;
    let accuracy = take_accuracy(&mut scene)?;
    registry.check_open()?;
    let planned = planned(&services, &scene, &asker).await?;
    let cancel = CancelToken::new();
    let _stops = StopsWithCall(cancel.clone());
    let told = begin(&services, planned, (accuracy, cancel.clone()), &asker)?;
    let follow = follow(&registry, told, (&sender, &cancel));
    let adapted = tokio::select! {
        adapted = follow => adapted?,
        () = asker.caller.revoked() => Err(Fault::Unauthenticated)?,
    };
    let Some((adapted, held)) = adapted else {
        return Ok(());
    };
    let refined = kept(&services, (scene, *adapted), (&asker.caller, held)).await?;
    send(&registry, &sender, Some(Part::Refined(refined))).await
}

/// Stops the work of a call that is left.
struct StopsWithCall(CancelToken);

impl Drop for StopsWithCall {
    fn drop(&mut self) {
        self.0.cancel();
    }
}

/// Sends rounds as they come; what came out of them, or none where the client has left.
async fn follow(
    registry: &Arc<Registry>,
    mut told: mpsc::UnboundedReceiver<Told>,
    (sender, cancel): (&Sender<wire::RefineMeshResponse>, &CancelToken),
) -> Result<Option<(Box<Adapted>, Reservation)>, Fault> {
    let heartbeat = registry.pace().heartbeat;
    let mut silent = Duration::ZERO;
    loop {
        let next = tokio::select! {
            next = tokio::time::timeout(LOOK, told.recv()) => next,
            () = sender.closed() => return Ok(None),
        };
        match next {
            Ok(Some(Told::Round(round))) => {
                let round = refinement::round(&round);
                send(registry, sender, Some(Part::Round(round))).await?;
                silent = Duration::ZERO;
            }
            Ok(Some(Told::Ended(Ok(outcome)))) => return outcome.map(Some),
            Ok(Some(Told::Ended(Err(panicked)))) => {
                tracing::error!(said = panicked.to_string(), "a refinement panicked");
                return Err(Fault::Internal);
            }
            Ok(None) => return Err(Fault::ShuttingDown),
            Err(_) => {
                if let Err(fault) = registry.check_open() {
                    cancel.cancel();
                    return Err(fault);
                }
                silent += LOOK;
                if silent >= heartbeat {
                    send(registry, sender, None).await?;
                    silent = Duration::ZERO;
                }
            }
        }
    }
}

/// Sends a message to a client that reads; a client that has left is noticed elsewhere.
async fn send(
    registry: &Arc<Registry>,
    sender: &Sender<wire::RefineMeshResponse>,
    part: Option<Part>,
) -> Result<(), Fault> {
    let unread = registry.pace().unread;
    let message = Ok(wire::RefineMeshResponse { part });
    match sender.send_timeout(message, unread).await {
        Ok(()) | Err(SendTimeoutError::Closed(_)) => Ok(()),
        Err(SendTimeoutError::Timeout(_)) => Err(Fault::StreamUnread {
            seconds: unread.as_secs(),
        }),
    }
}
