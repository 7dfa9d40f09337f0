//! Meshes that are refined until goals are known well enough: rounds on a solver thread, and the
//! last mesh kept as one that was sent. The work ends where it is cancelled, and with the longest
//! time of a step.

use std::sync::Arc;
use std::time::{Duration, Instant};

use signorini::adapted::{Accuracy, Adapted, AdaptionError, Problem, Round, Watch, adapt};
use signorini::mesh::Mesh;
use signorini::report::{CancelToken, IterationRecord, Observer, Termination};
use signorini::scene::{Scene, Step};
use signorini_proto::v1 as wire;
use tokio::sync::mpsc;

use super::planning::{self, Planned, aside, meshes};
use crate::compute::{Length, Panicked, Slot};
use crate::convert::{mesh as convert, refinement};
use crate::door::access::Caller;
use crate::door::client_key::ClientKey;
use crate::fault::Fault;
use crate::process::memory;
use crate::session::Services;
use crate::uploads::store::Reservation;

/// Who asks.
pub(crate) struct Asker {
    pub(crate) caller: Caller,
    pub(crate) client: ClientKey,
}

/// The scene on its mesh.
pub(crate) async fn planned(
    services: &Arc<Services>,
    scene: &wire::Scene,
    asker: &Asker,
) -> Result<Planned, Fault> {
    let client = asker.client.identity;
    check_queue(services, asker)?;
    planning::check_uploads(services, scene, &asker.caller).await?;
    let _turn = services.gates.plans.turn(client).await;
    planning::plan(services, scene.clone()).await
}

/// Refuses a client whose queue is full.
fn check_queue(services: &Services, asker: &Asker) -> Result<(), Fault> {
    let limit = services.config.maximum_queued;
    if services.solvers.waiting(asker.client.identity) < limit {
        Ok(())
    } else {
        Err(Fault::QueueFull { limit })
    }
}

/// What the work tells.
pub(crate) enum Told {
    Round(Round),
    /// How it ended.
    Ended(Result<Outcome, Panicked>),
}

/// What is kept of rounds, with the memory that is held for it.
pub(crate) type Outcome = Result<(Box<Adapted>, Reservation), Fault>;

/// Puts the rounds on a solver thread.
pub(crate) fn begin(
    services: &Arc<Services>,
    planned: Planned,
    (accuracy, cancel): (Accuracy, CancelToken),
    asker: &Asker,
) -> Result<mpsc::UnboundedReceiver<Told>, Fault> {
    // Many calls of a client may have been planned since the first look.
    check_queue(services, asker)?;
    let account = services.account(asker.client.identity);
    let bytes = planned.plan.first_bytes();
    let reservation = services.store.reserve_for(account, bytes)?;
    let (scene, mut steps) = planned.request.into_parts()?;
    if steps.is_empty() {
        steps.push(Step::default());
    }
    let work = Work {
        scene,
        steps,
        mesh: Arc::clone(planned.mesh.value()),
        accuracy,
        reservation,
        longest: services.config.step_time(),
        cancel,
    };
    let (tell, told) = mpsc::unbounded_channel();
    let (rounds, span) = (tell.clone(), tracing::Span::current());
    let flow = asker.client.flow(services.solvers.new_session());
    let lease = planned.mesh;
    services.solvers.submit(
        flow,
        Length::Long,
        move |slot| {
            // The mesh stays in the store meanwhile.
            let _lease = lease;
            span.in_scope(|| work.run(slot, &rounds))
        },
        // Nobody listens once the client has left.
        move |outcome| drop(tell.send(Told::Ended(outcome))),
    );
    Ok(told)
}

/// What a solver thread works on.
struct Work {
    scene: Scene,
    steps: Vec<Step>,
    mesh: Arc<Mesh>,
    accuracy: Accuracy,
    reservation: Reservation,
    longest: Option<Duration>,
    cancel: CancelToken,
}

impl Work {
    fn run(mut self, slot: &Slot, rounds: &mpsc::UnboundedSender<Told>) -> Outcome {
        let failed = |error: memory::OutOfMemory| Fault::RefinementFailed(error.to_string());
        memory::probe(self.reservation.bytes()).map_err(failed)?;
        let mut turns = Turns {
            slot,
            cancel: &self.cancel,
            longest: self.longest,
            begun: Instant::now(),
            paused: Duration::ZERO,
            is_late: false,
        };
        let reservation = &mut self.reservation;
        let watch = Watch {
            rounds: &mut |round| drop(rounds.send(Told::Round(round.clone()))),
            observer: &mut turns,
            room: &mut |bytes| memory::probe(bytes).is_ok() && reservation.resize(bytes).is_ok(),
            cancel: &self.cancel,
        };
        let problem = Problem {
            scene: &self.scene,
            steps: &self.steps,
            mesh: &self.mesh,
        };
        let adapted = adapt(problem, &self.accuracy, watch);
        let adapted = adapted.map_err(|error| self.fault(error))?;
        if turns.is_late && adapted.rounds.is_empty() {
            return Err(Fault::StreamDeadline);
        }
        Ok((Box::new(adapted), self.reservation))
    }

    fn fault(&self, error: AdaptionError) -> Fault {
        if self.cancel.stopped() == Some(Termination::DeadlineExceeded) {
            return Fault::StreamDeadline;
        }
        refinement::fault(error)
    }
}

/// Lets others have the slot, and ends work that takes too long.
struct Turns<'a> {
    slot: &'a Slot,
    cancel: &'a CancelToken,
    longest: Option<Duration>,
    begun: Instant,
    /// Time in which others had the slot.
    paused: Duration,
    /// Whether the work was ended for its time.
    is_late: bool,
}

impl Observer for Turns<'_> {
    fn iteration(&mut self, record: &IterationRecord) {
        self.slot.show_residual(record.residuals.largest());
        let is_stopped = || self.cancel.stopped().is_some();
        self.paused += self.slot.pause(&is_stopped);
        let used = self.begun.elapsed().saturating_sub(self.paused);
        if self.longest.is_some_and(|longest| used > longest) {
            self.is_late = true;
            self.cancel.expire();
        }
    }
}

/// Keeps the last mesh; what is told of it.
pub(crate) async fn kept(
    services: &Arc<Services>,
    (mut scene, adapted): (wire::Scene, Adapted),
    (caller, held): (&Caller, Reservation),
) -> Result<wire::RefinedMesh, Fault> {
    let (end, why) = (refinement::end(&adapted.end), adapted.end.to_string());
    let journal = services.journal.clone();
    let made = aside(move || {
        let arrays = adapted.hierarchy.mesh().arrays();
        drop(adapted);
        meshes::made(arrays, None, journal.as_deref())
    });
    let mesh = made.await??;
    let (stored, _) = meshes::keep(services, mesh, (caller, held.bytes())).await?;
    drop(held);
    scene.mesh = convert::name(stored.value().id());
    caller.note(&scene.mesh);
    for obstacle in &mut scene.obstacles {
        if obstacle.surface() == wire::SurfaceGeometry::Smooth {
            // Arcs that were fitted belong to the mesh now.
            obstacle.surface = wire::SurfaceGeometry::AsMeshed.into();
        }
    }
    Ok(wire::RefinedMesh {
        mesh: Some(meshes::describe(services, stored)?),
        end: end.into(),
        why,
        scene: Some(scene),
    })
}
