//! Sessions: one actor each, a tokio task that owns the session's queue of
//! updates, its kept results and, while no solver thread has it, its state.
//!
//! The actor never computes and never waits for a socket or a solver: solver
//! threads answer by events, readers by the room in their outbox. Updates are
//! taken in sequence; each is one step, each increment one job of the solver threads.
//! One stream writes, any number watches.

mod actor;
mod clock;
mod glance;
mod handle;
mod ledger;
mod path;
mod queue;
mod recovered;
mod replay;
mod work;

use std::future::Future;
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime};

use signorini::plan::Plan;
use signorini::prepare::Prepared;
use signorini_proto::v1 as wire;

use crate::compute::SolverThreads;
use crate::config::Config;
use crate::convert::scene::Output;
use crate::door::client_key::{ClientIdentity, ClientKey};
use crate::door::gates::Gates;
use crate::fault::Fault;
use crate::fleet::{self, Fleet};
use crate::journal::{Journal, JournalError, Presence};
use crate::uploads::store::{Account, Lease, Reservation, Store};
use crate::uploads::surfaces::Surfaces;
use crate::watch::metrics::Metrics;
use crate::watch::traces::Traces;

pub(crate) use glance::{Glance, Latest, Runs};
pub(crate) use recovered::Recovered;

pub(crate) use handle::{
    Attachment, Command, Handle, OnDisconnect, OpenRequest, ReadRequest, Role,
};

/// What every session of a server shares.
pub(crate) struct Services {
    /// The settings, checked.
    pub(crate) config: Config,
    /// Where everything is counted.
    pub(crate) metrics: Arc<Metrics>,
    /// Meshes and prepared data, under one byte budget.
    pub(crate) store: Arc<Store>,
    /// Triangulated surfaces of tools.
    pub(crate) surfaces: Surfaces,
    /// The threads on which sessions compute.
    pub(crate) solvers: SolverThreads,
    /// Who may plan, upload and send large messages, and how much of it at one time.
    pub(crate) gates: Gates,
    /// Where traces of updates go.
    pub(crate) traces: Traces,
    /// The data folder, if there is one.
    pub(crate) journal: Option<Arc<Journal>>,
    /// Whether that folder is still there.
    pub(crate) presence: Option<Arc<Presence>>,
    /// Other servers that sessions may go on at.
    pub(crate) fleet: Option<Arc<Fleet>>,
}

impl Services {
    /// What says that a session is this server's, in a fleet.
    ///
    /// # Errors
    /// `SessionElsewhere` where that has ended while the session was being made or woken.
    pub(crate) fn lease(&self, name: &str) -> Result<Option<Arc<fleet::Lease>>, Fault> {
        let Some(fleet) = &self.fleet else {
            return Ok(None);
        };
        let elsewhere = || Fault::SessionElsewhere {
            name: name.to_owned(),
            owner: String::new(),
        };
        fleet.lease(name).ok_or_else(elsewhere).map(Some)
    }

    /// Refuses what would be lost because the data folder is no longer where it was.
    ///
    /// # Errors
    /// `Unwritable`.
    pub(crate) fn check_data(&self) -> Result<(), Fault> {
        let lost = self.presence.as_ref().and_then(|presence| presence.lost());
        lost.map_or(Ok(()), |why| Err(Fault::Unwritable(why)))
    }

    /// Whether probes shall send work here. Not asked of work itself, as [`Services::check_data`] is:
    /// only a try shows whether a disk still refuses to be written.
    ///
    /// # Errors
    /// `Unwritable`.
    pub(crate) fn check_ready(&self) -> Result<(), Fault> {
        self.check_data()?;
        let refusal = self
            .journal
            .as_ref()
            .and_then(|journal| journal.disk().refusal());
        refusal.map_or(Ok(()), |why| Err(Fault::Unwritable(why)))
    }

    /// What counts for a client, and how much of it there may be.
    pub(crate) fn account(&self, client: ClientIdentity) -> Account {
        let most = self.config.client_bytes();
        Account { client, most }
    }
}

/// Everything that a new session starts from.
pub(crate) struct SessionSpec {
    /// `sessions/{id}`.
    pub(crate) name: String,
    /// What says that it is this server's; none where the server is alone.
    pub(crate) lease: Option<Arc<fleet::Lease>>,
    /// What the solver will build and do.
    pub(crate) plan: Arc<Plan>,
    /// The plan as clients read it.
    pub(crate) plan_report: wire::Plan,
    /// The scene as it was asked for.
    pub(crate) scene: Arc<wire::Scene>,
    /// Who asked for it.
    pub(crate) client: ClientKey,
    /// What becomes of a running step when its stream leaves, unless that says so.
    pub(crate) on_disconnect: wire::DisconnectPolicy,
    /// The mesh, kept in the store as long as the session lives.
    pub(crate) mesh: Lease<signorini::mesh::Mesh>,
    /// The fields that come with results, and how often.
    pub(crate) output: Output,
    /// The session's part of the byte budget.
    pub(crate) reservation: Arc<Mutex<Reservation>>,
    /// Keeps prepared data that are there already until the session has them.
    pub(crate) prepared: Option<Lease<Prepared>>,
    /// Of one result with the fields of the scene, bytes.
    pub(crate) result_bytes: u64,
    /// Held by the scene and the plan, bytes.
    pub(crate) own_bytes: u64,
    /// Time without a call after which the session expires.
    pub(crate) ttl: Duration,
    /// When it was asked for.
    pub(crate) created: SystemTime,
    /// What the journal knows of it, for one that goes on.
    pub(crate) recovered: Option<Box<Recovered>>,
}

/// How a session's actor ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum SessionEnd {
    /// A client deleted it.
    Deleted,
    /// Nobody called for its time to live.
    Expired,
    /// The server shuts down.
    ShutDown,
    /// A defect ended the actor itself.
    Died,
    /// It goes on from the journal with the next call; the journal refused something.
    Interrupted(Option<JournalError>),
}

impl SessionEnd {
    /// The word in the log.
    fn name(&self) -> &'static str {
        match self {
            Self::Deleted => "deleted",
            Self::Expired => "expired",
            Self::ShutDown => "shut_down",
            Self::Died => "died",
            Self::Interrupted(_) => "interrupted",
        }
    }

    /// Whether a session in the journal goes on with the next call.
    pub(crate) fn is_interruption(&self) -> bool {
        match self {
            Self::ShutDown | Self::Died | Self::Interrupted(_) => true,
            Self::Deleted | Self::Expired => false,
        }
    }
}

/// Calls `ended` once, also when the actor panics.
struct EndGuard<F: FnOnce(SessionEnd)>(Option<F>);

impl<F: FnOnce(SessionEnd)> EndGuard<F> {
    fn end(&mut self, ending: SessionEnd) {
        if let Some(ended) = self.0.take() {
            ended(ending);
        }
    }
}

impl<F: FnOnce(SessionEnd)> Drop for EndGuard<F> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            tracing::error!("the actor of a session panicked");
        }
        self.end(SessionEnd::Died);
    }
}

async fn watched(run: impl Future<Output = SessionEnd>, ended: impl FnOnce(SessionEnd)) {
    // Made at the first poll: a task that a closing runtime refuses is dropped
    // inside `start`, where the caller may hold the lock that `ended` takes.
    let mut guard = EndGuard(Some(ended));
    guard.end(run.await);
}

/// Starts the actor of a session; `ended` is called when it is over.
pub(crate) fn start(
    services: Arc<Services>,
    spec: SessionSpec,
    ended: impl FnOnce(SessionEnd) + Send + 'static,
) -> Handle {
    use tracing::Instrument;
    let span = tracing::info_span!("session", id = %spec.name);
    let (handle, inbox) = Handle::new(&spec.name, &spec.scene);
    let mailbox = (inbox, handle.parting());
    let run = watched(actor::run(services, spec, mailbox), ended);
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
        assert_eq!(receiver.await, Ok(SessionEnd::Died));
    }
}
