//! Sessions: one actor each, a tokio task that owns the session's queue of
//! updates, its kept results and, while no solver thread has it, its state.
//!
//! The actor never computes and never waits for a socket or a solver: solver
//! threads answer by events, readers by the room in their outbox. Updates are
//! taken in sequence; each is one step, each increment one job of the workshop.
//! One stream writes, any number watches.

mod actor;
pub(crate) mod blank;
mod handle;
mod iterations;
mod kept;
mod pump;
mod queue;
mod readers;
mod stream;
mod watch;
mod work;

use std::future::Future;
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime};

use signorini::plan::{Plan, Prepared};
use signorini_proto::v1 as wire;

use crate::client_key::ClientKey;
use crate::compute::Workshop;
use crate::config::Config;
use crate::convert::scene::Output;
use crate::metrics::Metrics;
use crate::store::{Lease, Reservation, Store};

pub(crate) use handle::{Handle, ReadRequest};
#[cfg(test)]
pub(crate) use iterations::Iterations;
pub(crate) use iterations::{IterationReader, Newest};
pub(crate) use kept::{KeptResult, messages};
pub(crate) use stream::{Call, open as open_stream};
pub(crate) use watch::open as open_watch;

/// What every session of a server shares.
pub(crate) struct Shop {
    pub(crate) config: Config,
    pub(crate) metrics: Arc<Metrics>,
    pub(crate) store: Arc<Store>,
    pub(crate) workshop: Workshop,
}

/// Everything that a new session starts from.
pub(crate) struct Seed {
    /// `sessions/{id}`.
    pub(crate) name: String,
    pub(crate) plan: Arc<Plan>,
    pub(crate) plan_report: wire::Plan,
    pub(crate) scene: Arc<wire::Scene>,
    /// Who asked for it.
    pub(crate) client: ClientKey,
    pub(crate) on_disconnect: wire::DisconnectPolicy,
    pub(crate) mesh: Lease<signorini::mesh::Mesh>,
    pub(crate) output: Output,
    pub(crate) reservation: Arc<Mutex<Reservation>>,
    /// Keeps prepared data that are there already until the session has them.
    pub(crate) prepared: Option<Lease<Prepared>>,
    /// Held by the scene and the plan, bytes.
    pub(crate) own_bytes: u64,
    pub(crate) ttl: Duration,
    pub(crate) created: SystemTime,
}

/// How a session's actor ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    Deleted,
    Expired,
    ShutDown,
    /// A defect ended the actor itself.
    Died,
}

/// Calls `ended` once, also when the actor panics.
struct Farewell<F: FnOnce(Ending)>(Option<F>);

impl<F: FnOnce(Ending)> Farewell<F> {
    fn say(&mut self, ending: Ending) {
        if let Some(ended) = self.0.take() {
            ended(ending);
        }
    }
}

impl<F: FnOnce(Ending)> Drop for Farewell<F> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            tracing::error!("the actor of a session panicked");
        }
        self.say(Ending::Died);
    }
}

async fn watched(run: impl Future<Output = Ending>, ended: impl FnOnce(Ending)) {
    // Made at the first poll: a task that a closing runtime refuses is dropped
    // inside `start`, where the caller may hold the lock that `ended` takes.
    let mut farewell = Farewell(Some(ended));
    farewell.say(run.await);
}

/// Starts the actor of a session; `ended` is called when it is over.
pub(crate) fn start(
    shop: Arc<Shop>,
    seed: Seed,
    ended: impl FnOnce(Ending) + Send + 'static,
) -> Handle {
    use tracing::Instrument;
    let span = tracing::info_span!("session", name = %seed.name);
    let (handle, inbox) = Handle::new(&seed.name, &seed.scene);
    let run = watched(actor::run(shop, seed, inbox), ended);
    tokio::spawn(run.instrument(span));
    handle
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn an_actor_that_panics_has_ended_too() {
        let (sender, receiver) = tokio::sync::oneshot::channel();
        let run = async { panic!("broken") };
        let ended = move |ending| sender.send(ending).unwrap();
        assert!(tokio::spawn(watched(run, ended)).await.is_err());
        assert_eq!(receiver.await, Ok(Ending::Died));
    }
}
