//! What a session stands on before its first step: built, found, or replayed.

use std::sync::{Arc, Mutex};

use signorini::Reuse;
use signorini::mesh::Mesh;
use signorini::plan::Plan;
use signorini::prepare::{PrepareError, Prepared};
use signorini::report::CancelToken;
use tokio::sync::{mpsc, oneshot};

use super::{Event, ResponseProgress, Work};
use crate::compute::{Length, Panicked};
use crate::door::client_key::Flow;
use crate::fault::FailureCause;
use crate::process::memory::{self, OutOfMemory};
use crate::session::Services;
use crate::session::replay::{Ground, Replay, ReplayError, Replayed};
use crate::uploads::store::{Lease, Reservation};
/// A session that can step.
pub(in crate::session) struct Ready {
    pub(in crate::session) work: Box<Work>,
    pub(in crate::session) prepared: Lease<Prepared>,
    pub(in crate::session) reuse: Reuse,
    pub(in crate::session) state_bytes: u64,
    pub(in crate::session) response: ResponseProgress,
    pub(in crate::session) replayed: Replayed,
}

/// Why a session cannot step.
#[derive(Debug, thiserror::Error)]
pub(in crate::session) enum Unprepared {
    #[error(transparent)]
    Failed(#[from] PrepareError),
    #[error(transparent)]
    Memory(#[from] OutOfMemory),
    #[error("a defect of the server; its log says more")]
    Panicked(#[from] Panicked),
    #[error("the server is shutting down")]
    Closed,
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

impl Unprepared {
    /// Whether a replay found something otherwise than the first run.
    pub(in crate::session) fn is_difference(&self) -> bool {
        match self {
            Self::Replay(error) => error.is_difference(),
            Self::Failed(_) | Self::Memory(_) | Self::Panicked(_) | Self::Closed => false,
        }
    }

    pub(in crate::session) fn cause(&self) -> FailureCause {
        match self {
            Self::Memory(_) => FailureCause::Memory,
            Self::Failed(_) | Self::Panicked(_) | Self::Closed | Self::Replay(_) => {
                FailureCause::Other
            }
        }
    }
}

/// Unknowns from which a body is long work before anything of it has run: some 0.3 s
/// a factorisation on one core.
const LONG_UNKNOWNS: u64 = 60_000;

/// Whether work on a plan is long, as far as its size tells.
pub(in crate::session) fn length(plan: &Plan) -> Length {
    if plan.report().unknowns.displacement < LONG_UNKNOWNS {
        Length::Short
    } else {
        Length::Long
    }
}

/// What [`prepare`] builds from.
pub(in crate::session) struct Preparation {
    pub(in crate::session) plan: Arc<Plan>,
    pub(in crate::session) mesh: Arc<Mesh>,
    /// Whose share it uses.
    pub(in crate::session) flow: Flow,
    pub(in crate::session) cancel: CancelToken,
    /// Held as long as the work may hold memory.
    pub(in crate::session) reservation: Arc<Mutex<Reservation>>,
    /// What an earlier server did in this session.
    pub(in crate::session) replay: Option<Box<Replay>>,
}

/// Builds what the plan needs, or finds it, and tells the actor.
pub(in crate::session) async fn prepare(
    services: Arc<Services>,
    preparation: Preparation,
    events: mpsc::UnboundedSender<Event>,
) {
    let outcome = ready(&services, preparation).await;
    // A session that is gone needs nothing.
    let _gone = events.send(Event::Prepared(outcome.map(Box::new)));
}

async fn ready(services: &Arc<Services>, preparation: Preparation) -> Result<Ready, Unprepared> {
    let Preparation {
        plan,
        mesh,
        flow,
        cancel,
        reservation,
        replay,
    } = preparation;
    let turn = services.store.turn(plan.key());
    let guard = turn.lock().await;
    let (prepared, reuse) = match services.store.prepared(&plan.key()) {
        Some(lease) => (lease, Reuse::Reused),
        None => {
            memory::probe(plan.first_bytes())?;
            let (for_build, on) = (Arc::clone(&plan), Arc::clone(&mesh));
            let held = Arc::clone(&reservation);
            let build = move || {
                let built = Prepared::build(&for_build, &on, &cancel);
                drop(held);
                built
            };
            let length = length(&plan);
            let built = on_solver(services, flow, length, build).await??;
            (
                services.store.insert_prepared(plan.key(), mesh.id(), built),
                Reuse::Built,
            )
        }
    };
    drop(guard);
    let shared = Arc::clone(prepared.value());
    let ground = Ground {
        plan,
        mesh,
        prepared: shared,
        reuse,
    };
    let length = match &replay {
        None => Length::Short,
        Some(_) => Length::Long,
    };
    let begin = move || match replay {
        None => Ok((ground.session(), None, Replayed::default())),
        Some(replay) => (*replay).run(ground),
    };
    let (session, run, replayed) = on_solver(services, flow, length, begin).await??;
    drop(reservation);
    Ok(Ready {
        state_bytes: session.bytes(),
        response: ResponseProgress::of(&session),
        work: Box::new(Work { session, run }),
        prepared,
        reuse,
        replayed,
    })
}

async fn on_solver<T: Send + 'static>(
    services: &Services,
    flow: Flow,
    length: Length,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Unprepared> {
    let (sender, receiver) = oneshot::channel();
    services.solvers.submit(
        flow,
        length,
        |_| work(),
        move |outcome| {
            // The session may be gone; its value is dropped then.
            let _gone = sender.send(outcome);
        },
    );
    let outcome = receiver.await.map_err(|_| Unprepared::Closed)?;
    if let Err(Panicked(said)) = &outcome {
        tracing::error!(said, "preparation panicked");
    }
    Ok(outcome?)
}
