//! The actor: one session's state machine.
//!
//! The session's state is in one of five places ([`Place`]): not built yet, at
//! home, in a parcel on its way through a solver thread, left behind with a
//! thread that does not stop, or lost. After every event [`Actor::proceed`] does
//! the one thing that can be done next; nothing else starts work.
//!
//! A step that shall stop is answered, when those before it are, at once while it
//! waits, and by its solver thread within one Krylov iteration while it runs. A thread that does not
//! answer in time is left behind: the step ends with the last good state, and
//! what the thread brings later is undone.

mod describe;
mod results;
mod stop;
mod streams;
mod updates;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

use signorini::plan::Prepared;
use signorini::report::{CancelToken, FieldName, StepReport, Termination};
use signorini::{ObstaclePose, Reuse};
use signorini_proto::v1 as wire;
use tokio::sync::{Notify, mpsc, oneshot, watch};
use tokio::time::Instant;

use super::handle::{Command, Pulse};
use super::iterations::Iterations;
use super::kept::Kept;
use super::queue::Queue;
use super::readers::{Fresh, Reader};
use super::work::{self, Event, Order, Outcome, Parcel, Ready, Task, Work};
use super::{Ending, Seed, Shop};
use crate::client_key::ClientKey;
use crate::compute::Panicked;
use crate::config::LONGEST_SECONDS;
use crate::fault::Fault;
use crate::store::{Lease, Reservation};

/// Where the state of the session is.
enum Place {
    Preparing,
    Home(Box<Work>),
    Away(Parcel),
    /// With a solver thread whose step is answered already.
    Behind,
    Lost(String),
}

/// The stream that writes.
struct Writer {
    number: u64,
    reader: Reader,
    since: SystemTime,
    on_disconnect: wire::DisconnectPolicy,
    deadline: Option<Instant>,
    half_closed: bool,
}

/// A stream that only reads.
struct Watcher {
    reader: Reader,
    until: wire::WatchEnd,
}

struct Actor {
    shop: Arc<Shop>,
    seed: Seed,
    place: Place,
    queue: Queue,
    kept: Kept,
    writer: Option<Writer>,
    watchers: BTreeMap<u64, Watcher>,
    /// Streams so far.
    streams: u64,
    /// Fields that the last writer wanted; those of the scene before the first.
    fields: Vec<FieldName>,
    /// Whose share of the solver threads the session uses.
    client: ClientKey,
    iterations: Iterations,
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
    /// Some reader has room again.
    room: Arc<Notify>,
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
        let room = Arc::clone(&actor.room);
        tokio::select! {
            command = inbox.recv() => match command {
                Some(command) => actor.command(command),
                // Every handle is gone, so nobody can ask for the session again.
                None => actor.end(Ending::Deleted),
            },
            Some(event) = arrived.recv() => actor.event(event),
            () = room.notified() => actor.feed(None),
            () = tokio::time::sleep_until(actor.expires), if actor.is_idle() => {
                actor.end(Ending::Expired);
            }
        }
    }
}

impl Actor {
    fn new(shop: Arc<Shop>, seed: Seed, events: mpsc::UnboundedSender<Event>) -> Self {
        let config = &shop.config;
        Self {
            kept: Kept::new(config.retained_results, config.retained_field_bytes),
            expires: after(seed.ttl),
            state_bytes: 0,
            place: Place::Preparing,
            queue: Queue::default(),
            writer: None,
            watchers: BTreeMap::new(),
            streams: 0,
            fields: seed.output.fields.clone(),
            client: seed.client,
            iterations: Iterations::default(),
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
            room: Arc::new(Notify::new()),
            shop,
            seed,
        }
    }

    fn start_preparing(&self) {
        let order = Order {
            plan: Arc::clone(&self.seed.plan),
            mesh: Arc::clone(self.seed.mesh.value()),
            client: self.client,
            cancel: self.stop_preparing.clone(),
            reservation: Arc::clone(&self.seed.reservation),
        };
        let (shop, events) = (Arc::clone(&self.shop), self.events.clone());
        tokio::spawn(work::prepare(shop, order, events));
    }

    fn command(&mut self, command: Command) {
        if !matches!(command, Command::List(_)) {
            self.expires = after(self.seed.ttl);
        }
        match command {
            Command::Attach(request, reply) => answer(reply, self.attach(*request)),
            Command::Detach(number) => self.detach(number),
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
                self.seed.prepared = None;
                tracing::warn!(%error, "preparation failed");
                self.place = Place::Lost(error.to_string());
            }
            Event::Advanced(outcome) => self.advanced(outcome),
            Event::Deadline(sequence) => self.deadline(sequence),
            Event::OutOfPatience(sequence) => self.leave_behind(sequence),
        }
    }

    fn advanced(&mut self, outcome: Result<Outcome, Panicked>) {
        let is_late = matches!(self.place, Place::Behind);
        match outcome {
            Ok(Outcome::Withdrawn) => {}
            Ok(Outcome::Increment(work, _)) if is_late => self.undo_late(work),
            Ok(Outcome::Refused(work, _) | Outcome::Broken(work, _)) if is_late => {
                self.come_home_late(work);
            }
            Ok(Outcome::Increment(work, increment)) => {
                self.place = Place::Home(work);
                self.finish_increment(*increment);
            }
            Ok(Outcome::Refused(work, error)) => {
                self.place = Place::Home(work);
                self.refuse_current(&error.into());
            }
            Ok(Outcome::Broken(work, why)) => {
                tracing::error!(why, "a step broke");
                self.place = Place::Home(work);
                self.finish_stopped(Termination::InternalError);
            }
            Err(panicked) => {
                tracing::error!(said = panicked.0, "a defect beside a step");
                self.place = Place::Lost("a defect of the server; its log says more".to_owned());
                self.finish_stopped(Termination::InternalError);
            }
        }
    }

    /// Does what can be done next.
    fn proceed(&mut self) {
        self.stop_here();
        if let Place::Lost(why) = &self.place {
            let name = self.seed.name.clone();
            let fault = Fault::SessionFailed {
                name,
                why: why.clone(),
            };
            self.refuse_all(&fault);
        } else if self.queue.is_empty() {
            self.end_finished_streams();
        } else if self.writer_has_room() {
            self.dispatch();
        }
        self.show();
    }

    /// Sends the current step's next increment to a solver thread.
    fn dispatch(&mut self) {
        if !matches!(self.place, Place::Home(_)) {
            return;
        }
        let (wanted, every) = (self.wanted(), self.seed.output.every);
        let scratch_bytes = self.scratch_bytes();
        let limit = self.seed.plan.scene().solver.max_wall_time;
        let Some(current) = self.queue.current() else {
            return;
        };
        current.start_clock(limit, &self.events);
        let task = Task {
            sequence: current.sequence,
            step: current.step.clone(),
            cancel: current.cancel.clone(),
            wanted,
            every,
            scratch_bytes,
            after_event: self.last_event,
            iterations: self.iterations.clone(),
            metrics: Arc::clone(&self.shop.metrics),
        };
        let parcel = Parcel::default();
        let empty = Place::Away(Arc::clone(&parcel));
        let Place::Home(work) = std::mem::replace(&mut self.place, empty) else {
            return;
        };
        *parcel.lock().unwrap_or_else(PoisonError::into_inner) = Some(work);
        let (span, events) = (tracing::Span::current(), self.events.clone());
        let held = Arc::clone(&self.seed.reservation);
        self.shop.workshop.submit(
            self.client,
            move || {
                let outcome = span.in_scope(|| work::advance(&parcel, &task));
                // The memory may outlive the session that asked for it.
                drop(held);
                outcome
            },
            move |outcome| {
                // A session that is gone needs no result.
                let _gone = events.send(Event::Advanced(outcome));
            },
        );
    }

    /// What an increment may have to allocate: all but what is there already.
    fn scratch_bytes(&self) -> u64 {
        self.predicted_rest().saturating_sub(self.state_bytes)
    }

    /// Fields that some reader wants; without a writer, those that the last one
    /// wanted, for it may come back.
    fn wanted(&self) -> Vec<FieldName> {
        let mut all = self.fields.clone();
        for watcher in self.watchers.values() {
            for field in watcher.reader.outbox.fields() {
                if !all.contains(field) {
                    all.push(*field);
                }
            }
        }
        all
    }

    fn ready(&mut self, ready: Ready) {
        self.state_bytes = ready.state_bytes;
        self.prepared = Some((ready.prepared, ready.reuse));
        self.seed.prepared = None;
        self.place = Place::Home(ready.work);
        self.account();
    }

    /// Counts what is held, and never less than was predicted: the solver's
    /// scratch stays with the session. Where that does not fit, older results go.
    fn account(&mut self) {
        let unread = self
            .writer
            .as_ref()
            .map_or(0, |writer| writer.reader.outbox.unread_bytes());
        let pinned = unread.saturating_sub(self.kept.bytes());
        let beside = self.seed.own_bytes + pinned;
        let state = self.state_bytes.max(self.predicted_rest());
        let mut reservation = lock(&self.seed.reservation);
        if let Err(lacking) = reservation.resize(beside + state + self.kept.bytes()) {
            self.kept.free(lacking);
            reservation.force(beside + state + self.kept.bytes());
        }
    }

    /// The prediction without what is shared.
    fn predicted_rest(&self) -> u64 {
        let predicted = self.seed.plan.report().predicted_bytes;
        predicted.saturating_sub(self.shared_bytes())
    }

    fn shared_bytes(&self) -> u64 {
        let own = self.prepared.as_ref().map(|(lease, _)| lease);
        let found = own.or(self.seed.prepared.as_ref());
        found.map_or(0, |lease| lease.value().bytes())
    }

    fn is_idle(&self) -> bool {
        self.queue.is_empty() && self.writer.is_none() && self.watchers.is_empty()
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
        self.end_streams(&self.parting());
        for deleter in self.deleters.drain(..) {
            answer(deleter, ());
        }
        Some(ending)
    }
}

fn lock(reservation: &Mutex<Reservation>) -> MutexGuard<'_, Reservation> {
    reservation.lock().unwrap_or_else(PoisonError::into_inner)
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
