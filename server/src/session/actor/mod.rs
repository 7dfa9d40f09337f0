//! The actor: one session's state machine.
//!
//! The session's state is in one of four places ([`Place`]): not built yet, at
//! home, in a parcel on its way through a solver thread, or lost to a defect.
//! After every event [`Actor::proceed`] does the one thing that can be done
//! next; nothing else starts work.

mod describe;
mod results;
mod updates;
mod writer;

use std::sync::{Arc, PoisonError};
use std::time::{Duration, SystemTime};

use signorini::plan::Prepared;
use signorini::report::{CancelToken, FieldName, StepReport, Termination};
use signorini::{ObstaclePose, Reuse};
use signorini_proto::v1 as wire;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::Instant;

use super::handle::{Command, Pulse};
use super::kept::Kept;
use super::queue::Queue;
use super::work::{self, Event, Outcome, Parcel, Ready, Subscriber, Task, Work};
use super::{Ending, Seed, Shop};
use crate::config::LONGEST_SECONDS;
use crate::convert::field::Encoding;
use crate::fault::Fault;
use crate::outbox::{End, Outbox};
use crate::store::Lease;

/// Where the state of the session is.
enum Place {
    Preparing,
    Home(Box<Work>),
    Away(Parcel),
    Lost(String),
}

/// The attached stream.
struct Writer {
    number: u64,
    outbox: Arc<Outbox>,
    since: SystemTime,
    fields: Vec<FieldName>,
    encoding: Encoding,
    on_disconnect: wire::DisconnectPolicy,
    half_closed: bool,
    /// Newest event sent on this stream.
    sent: i64,
}

impl Drop for Writer {
    fn drop(&mut self) {
        // The first end stays, so this one reaches only the stream of an actor
        // that died.
        self.outbox.end(End::Fault(Fault::Internal));
    }
}

struct Actor {
    shop: Arc<Shop>,
    seed: Seed,
    place: Place,
    queue: Queue,
    kept: Kept,
    writer: Option<Writer>,
    writers: u64,
    subscriber: Subscriber,
    last_finished: i64,
    last_event: i64,
    /// Of the last increment that a solver finished.
    last_report: Option<StepReport>,
    last_poses: Vec<ObstaclePose>,
    prepared: Option<(Lease<Prepared>, Reuse)>,
    state_bytes: u64,
    expires: Instant,
    stop_preparing: CancelToken,
    ending: Option<Ending>,
    deleters: Vec<oneshot::Sender<()>>,
    pulse: watch::Sender<Pulse>,
    events: mpsc::UnboundedSender<Event>,
}

/// Runs a session until it ends.
pub(in crate::session) async fn run(
    shop: Arc<Shop>,
    seed: Seed,
    mut inbox: mpsc::Receiver<Command>,
) -> Ending {
    let (events, mut arrived) = mpsc::unbounded_channel();
    let mut actor = Actor::new(shop, seed, events);
    actor.start_preparing();
    loop {
        actor.proceed();
        if let Some(ending) = actor.over() {
            return ending;
        }
        let outbox = actor
            .writer
            .as_ref()
            .map(|writer| Arc::clone(&writer.outbox));
        tokio::select! {
            command = inbox.recv() => match command {
                Some(command) => actor.command(command),
                // Every handle is gone, so nobody can ask for the session again.
                None => actor.end(Ending::Deleted),
            },
            Some(event) = arrived.recv() => actor.event(event),
            () = drained(outbox) => {}
            () = tokio::time::sleep_until(actor.expires), if actor.is_idle() => {
                actor.end(Ending::Expired);
            }
        }
    }
}

async fn drained(outbox: Option<Arc<Outbox>>) {
    match outbox {
        Some(outbox) => outbox.drained().await,
        None => std::future::pending().await,
    }
}

impl Actor {
    fn new(shop: Arc<Shop>, seed: Seed, events: mpsc::UnboundedSender<Event>) -> Self {
        let config = &shop.config;
        Self {
            kept: Kept::new(config.retained_results, config.retained_field_bytes),
            expires: after(seed.ttl),
            state_bytes: seed.reservation.bytes(),
            place: Place::Preparing,
            queue: Queue::default(),
            writer: None,
            writers: 0,
            subscriber: Subscriber::default(),
            last_finished: 0,
            last_event: 0,
            last_report: None,
            last_poses: Vec::new(),
            prepared: None,
            stop_preparing: CancelToken::new(),
            ending: None,
            deleters: Vec::new(),
            pulse: watch::Sender::new((wire::SessionState::Preparing, 0)),
            events,
            shop,
            seed,
        }
    }

    fn start_preparing(&self) {
        let (plan, mesh) = (
            Arc::clone(&self.seed.plan),
            Arc::clone(self.seed.mesh.value()),
        );
        let (cancel, events) = (self.stop_preparing.clone(), self.events.clone());
        tokio::spawn(work::prepare(
            Arc::clone(&self.shop),
            plan,
            mesh,
            cancel,
            events,
        ));
    }

    fn command(&mut self, command: Command) {
        if !matches!(command, Command::List(_)) {
            self.expires = after(self.seed.ttl);
        }
        match command {
            Command::Attach(request, reply) => answer(reply, self.attach(*request)),
            Command::Detach(writer) => self.detach(writer),
            Command::HalfClose(number) => {
                if let Some(writer) = self.writer_of(number) {
                    writer.half_closed = true;
                }
            }
            Command::Update(number, update) => {
                if self.writer_of(number).is_some() {
                    self.update(*update);
                }
            }
            Command::Reject(number, sequence, fault) => {
                if self.writer_of(number).is_some() {
                    self.reject(sequence, &fault);
                }
            }
            Command::CancelFrom(number, sequence) => {
                if self.writer_of(number).is_some() {
                    self.cancel(sequence);
                }
            }
            Command::Cancel(sequence, reply) => answer(reply, self.cancel(sequence)),
            Command::Describe(reply) | Command::List(reply) => answer(reply, self.describe()),
            Command::Handled(reply) => answer(reply, ()),
            Command::Read(request, reply) => answer(reply, self.read(&request)),
            Command::Delete(reply) => {
                self.deleters.push(reply);
                self.end(Ending::Deleted);
            }
            Command::ShutDown => self.end(Ending::ShutDown),
        }
    }

    fn event(&mut self, event: Event) {
        self.expires = after(self.seed.ttl);
        match event {
            Event::Prepared(Ok(ready)) => self.ready(*ready),
            Event::Prepared(Err(error)) => {
                tracing::warn!(%error, "preparation failed");
                self.place = Place::Lost(error.to_string());
            }
            Event::Advanced(Ok(Outcome::Withdrawn)) => {}
            Event::Advanced(Ok(Outcome::Increment(work, increment))) => {
                self.place = Place::Home(work);
                self.finish_increment(*increment);
            }
            Event::Advanced(Ok(Outcome::Refused(work, error))) => {
                self.place = Place::Home(work);
                self.refuse_current(&error.into());
            }
            Event::Advanced(Err(panicked)) => {
                tracing::error!(said = panicked.0, "a step panicked");
                self.lose("a defect of the server; its log says more");
                self.finish_stopped(Termination::InternalError);
            }
        }
    }

    /// Does what can be done next.
    fn proceed(&mut self) {
        while let Some(termination) = self.stopped_here() {
            self.finish_stopped(termination);
        }
        if let Place::Lost(why) = &self.place {
            let name = self.seed.name.clone();
            let fault = Fault::SessionFailed {
                name,
                why: why.clone(),
            };
            self.refuse_all(&fault);
        } else if self.queue.is_empty() {
            self.end_finished_stream();
        } else if self.has_room() {
            self.dispatch();
        }
        self.show();
    }

    /// How the current step ends when no solver thread has it and it shall stop.
    fn stopped_here(&mut self) -> Option<Termination> {
        let termination = self.queue.current()?.cancel.stopped()?;
        if let Place::Away(parcel) = &self.place {
            let work = work::take(parcel)?;
            self.place = Place::Home(work);
        }
        match self.place {
            Place::Lost(_) => None,
            Place::Preparing | Place::Home(_) | Place::Away(_) => Some(termination),
        }
    }

    fn has_room(&self) -> bool {
        self.writer
            .as_ref()
            .is_none_or(|writer| writer.outbox.has_room())
    }

    /// Sends the current step's next increment to a solver thread.
    fn dispatch(&mut self) {
        if !matches!(self.place, Place::Home(_)) {
            return;
        }
        let (wanted, every) = (self.wanted(), self.seed.output.every);
        let limit = self.seed.plan.scene().solver.max_wall_time;
        let Some(current) = self.queue.current() else {
            return;
        };
        current.start_clock(limit);
        let task = Task {
            sequence: current.sequence,
            step: current.step.clone(),
            cancel: current.cancel.clone(),
            wanted,
            every,
            subscriber: Arc::clone(&self.subscriber),
            metrics: Arc::clone(&self.shop.metrics),
        };
        let parcel = Parcel::default();
        let empty = Place::Away(Arc::clone(&parcel));
        let Place::Home(work) = std::mem::replace(&mut self.place, empty) else {
            return;
        };
        *parcel.lock().unwrap_or_else(PoisonError::into_inner) = Some(work);
        let (span, events) = (tracing::Span::current(), self.events.clone());
        self.shop.workshop.submit(
            move || span.in_scope(|| work::advance(&parcel, &task)),
            move |outcome| {
                // A session that is gone needs no result.
                let _gone = events.send(Event::Advanced(outcome));
            },
        );
    }

    /// Fields that the reader wants, or the scene when nobody reads.
    fn wanted(&self) -> Vec<FieldName> {
        match &self.writer {
            Some(writer) => writer.fields.clone(),
            None => self.seed.output.fields.clone(),
        }
    }

    fn ready(&mut self, ready: Ready) {
        self.state_bytes = ready.state_bytes;
        self.prepared = Some((ready.prepared, ready.reuse));
        self.place = Place::Home(ready.work);
        self.account();
    }

    fn lose(&mut self, why: &str) {
        self.place = Place::Lost(why.to_owned());
    }

    fn account(&mut self) {
        self.seed
            .reservation
            .resize(self.state_bytes + self.kept.bytes());
    }

    fn is_idle(&self) -> bool {
        self.queue.is_empty() && self.writer.is_none()
    }

    /// Stops everything; [`Actor::over`] says when that has happened.
    fn end(&mut self, ending: Ending) {
        self.ending.get_or_insert(ending);
        self.stop_preparing.cancel();
        for dropped in self.queue.keep_current() {
            self.reject(dropped.sequence, &self.parting());
        }
        self.cancel(0);
    }

    fn parting(&self) -> Fault {
        match self.ending {
            Some(Ending::ShutDown) => Fault::ShuttingDown,
            Some(Ending::Expired) => Fault::SessionExpired(self.seed.name.clone()),
            Some(Ending::Deleted | Ending::Died) | None => {
                Fault::SessionDeleted(self.seed.name.clone())
            }
        }
    }

    /// The ending, when nothing runs any more.
    fn over(&mut self) -> Option<Ending> {
        let ending = self.ending.filter(|_| self.queue.is_empty())?;
        if let Some(writer) = self.writer.take() {
            writer.outbox.end(End::Fault(self.parting()));
            self.shop.metrics.stream_closed();
        }
        for deleter in self.deleters.drain(..) {
            answer(deleter, ());
        }
        Some(ending)
    }
}

/// The instant `time` from now.
fn after(time: Duration) -> Instant {
    let now = Instant::now();
    now.checked_add(time)
        .unwrap_or(now + Duration::from_secs(LONGEST_SECONDS))
}

fn answer<T>(reply: oneshot::Sender<T>, value: T) {
    // Whoever asked may have left.
    let _left = reply.send(value);
}
