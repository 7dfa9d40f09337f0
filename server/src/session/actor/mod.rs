//! The actor: one session's state machine.
//!
//! The session's state is in one of five places ([`Place`]): not built yet, at
//! home, handed over to a solver thread, left behind with a thread that does not
//! stop, or lost. After every event [`Actor::proceed`] does the one thing that can
//! be done next; nothing else starts work.
//!
//! A step that shall stop is answered, when those before it are, at once while it
//! waits, and by its solver thread within one Krylov iteration while it runs. A
//! thread that does not answer in time is left behind: the step ends with the last
//! good state, and what the thread brings later is undone.

mod describe;
mod export;
mod journal;
mod log;
mod memory;
mod results;
mod saves;
mod stop;
mod streams;
mod updates;

use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, SystemTime};

use signorini::Reuse;
use signorini::prepare::Prepared;
use signorini::report::{CancelToken, FieldName, Termination};
use signorini_proto::v1 as wire;
use tokio::sync::{Notify, mpsc, oneshot, watch};
use tokio::time::Instant;

use super::handle::{Command, Parting, Pulse};
use super::queue::UpdateQueue;
use super::work::{self, Event, Handoff, Outcome, Preparation, Ready, Task, Work};
use super::{Services, SessionEnd, SessionSpec};
use crate::client_key::ClientKey;
use crate::compute::{Length, Panicked};
use crate::config::LONGEST_SECONDS;
use crate::fault::{FailureCause, Fault};
use crate::results::iterations::Iterations;
use crate::results::kept::Kept;
use crate::results::readers::{Fresh, Reader};
use crate::store::Lease;
use export::{Visit, Visits};
use journal::Log;
use saves::Saves;

/// Where the state of the session is.
enum Place {
    Preparing,
    Home(Box<Work>),
    Away(Handoff),
    /// With a solver thread whose step is answered already.
    Behind,
    Lost(Loss),
}

/// Why there is no state any more.
struct Loss {
    why: String,
    cause: FailureCause,
}

impl Loss {
    fn by_a_defect() -> Self {
        Self {
            why: "a defect of the server; its log says more".to_owned(),
            cause: FailureCause::Other,
        }
    }
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
    services: Arc<Services>,
    spec: SessionSpec,
    place: Place,
    queue: UpdateQueue,
    kept: Kept,
    writer: Option<Writer>,
    watchers: BTreeMap<u64, Watcher>,
    /// Streams so far.
    streams: u64,
    /// Fields that the last writer wanted; those of the scene before the first.
    fields: Vec<FieldName>,
    /// Whose share of the solver threads the session uses.
    client: ClientKey,
    /// Under which it has a share of its client's.
    number: u64,
    /// The last increment was long work.
    was_long: bool,
    iterations: Iterations,
    last_finished: i64,
    last_event: i64,
    /// A step was stopped before the state was there to stop in.
    is_stopped_early: bool,
    /// Of the last increment that a solver finished.
    last_report: Option<wire::StepReport>,
    /// The newest result, for readers that see it when the disk has it.
    fresh: Option<Fresh>,
    /// What the data folder knows of the session.
    log: Log,
    prepared: Option<(Lease<Prepared>, Reuse)>,
    state_bytes: u64,
    expires: Instant,
    stop_preparing: CancelToken,
    ending: Option<SessionEnd>,
    deleters: Vec<oneshot::Sender<()>>,
    /// Who waits for the state, or for its being on disk.
    visits: Visits,
    /// States to go back to.
    saves: Saves,
    pulse: watch::Sender<Pulse>,
    events: mpsc::UnboundedSender<Event>,
    /// Some reader has room again.
    room: Arc<Notify>,
}

/// Runs a session until it ends.
pub(in crate::session) async fn run(
    services: Arc<Services>,
    spec: SessionSpec,
    (mut inbox, parting): (mpsc::Receiver<Command>, Parting),
) -> SessionEnd {
    let (events, mut arrived) = mpsc::unbounded_channel();
    let mut actor = Actor::new(services, spec, events);
    actor.log_start();
    actor.start_preparing();
    loop {
        actor.proceed();
        if let Some(ending) = actor.over() {
            // Before the inbox closes: whoever asks then is told this.
            parting.get_or_init(|| actor.parting());
            actor.log_end(&ending);
            actor.forget_stored(&ending).await;
            return ending;
        }
        let room = Arc::clone(&actor.room);
        tokio::select! {
            command = inbox.recv() => match command {
                Some(command) => actor.command(command),
                // Every handle is gone, so nobody can ask for the session again.
                None => actor.end(SessionEnd::Deleted),
            },
            Some(event) = arrived.recv() => actor.event(event),
            () = room.notified() => actor.feed(None),
            () = tokio::time::sleep_until(actor.expires), if actor.is_idle() => {
                actor.end(SessionEnd::Expired);
            }
        }
    }
}

impl Actor {
    fn new(
        services: Arc<Services>,
        spec: SessionSpec,
        events: mpsc::UnboundedSender<Event>,
    ) -> Self {
        let config = &services.config;
        Self {
            kept: kept(&services),
            expires: after(spec.ttl),
            state_bytes: 0,
            place: Place::Preparing,
            queue: UpdateQueue::default(),
            writer: None,
            watchers: BTreeMap::new(),
            streams: 0,
            fields: spec.output.fields.clone(),
            client: spec.client,
            number: services.solvers.new_session(),
            was_long: false,
            iterations: Iterations::default(),
            last_finished: 0,
            last_event: 0,
            is_stopped_early: false,
            last_report: None,
            fresh: None,
            log: Log::new(services.journal.is_some(), config.retained_results),
            prepared: None,
            stop_preparing: CancelToken::new(),
            ending: None,
            deleters: Vec::new(),
            visits: Visits::default(),
            saves: Saves::default(),
            pulse: watch::Sender::new((wire::SessionState::Preparing, 0)),
            events,
            room: Arc::new(Notify::new()),
            services,
            spec,
        }
    }

    fn start_preparing(&mut self) {
        let replay = self.recover();
        let preparation = Preparation {
            plan: Arc::clone(&self.spec.plan),
            mesh: Arc::clone(self.spec.mesh.value()),
            flow: self.client.flow(self.number),
            cancel: self.stop_preparing.clone(),
            reservation: Arc::clone(&self.spec.reservation),
            replay,
        };
        let (services, events) = (Arc::clone(&self.services), self.events.clone());
        tokio::spawn(work::prepare(services, preparation, events));
    }

    fn command(&mut self, command: Command) {
        if !matches!(command, Command::List(_)) {
            self.expires = after(self.spec.ttl);
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
            Command::Export(reply) => self.visit(Visit::Export(reply)),
            Command::Save(reply) => self.visit(Visit::Save(reply)),
            Command::Restore(number, reply) => self.visit(Visit::Restore(number, reply)),
            Command::Delete(reply) => {
                self.deleters.push(reply);
                self.end(SessionEnd::Deleted);
            }
            Command::ShutDown => self.end(SessionEnd::ShutDown),
        }
    }

    fn event(&mut self, event: Event) {
        self.expires = after(self.spec.ttl);
        match event {
            Event::Prepared(Ok(ready)) => self.ready(*ready),
            Event::Prepared(Err(error)) => {
                self.spec.prepared = None;
                tracing::warn!(cause = error.to_string(), "preparation failed");
                self.place = Place::Lost(Loss {
                    why: error.to_string(),
                    cause: error.cause(),
                });
            }
            Event::Advanced(outcome) => self.advanced(outcome),
            Event::Deadline(sequence) => self.deadline(sequence),
            Event::Ceiling(sequence) => self.ceiling(sequence),
            Event::OutOfPatience(sequence) => self.leave_behind(sequence),
            Event::Journalled(mark, outcome) => self.journalled(mark, outcome),
            Event::Exported(outcome) => self.exported(outcome),
        }
    }

    fn advanced(&mut self, outcome: Result<Outcome, Panicked>) {
        let is_late = matches!(self.place, Place::Behind);
        match outcome {
            Ok(Outcome::Withdrawn) => {}
            Ok(Outcome::Increment(work, increment)) if is_late => {
                self.undo_late(work, &increment);
            }
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
                self.place = Place::Lost(Loss::by_a_defect());
                self.finish_stopped(Termination::InternalError);
            }
        }
    }

    /// Does what can be done next.
    fn proceed(&mut self) {
        self.stop_here();
        if let Some(fault) = self.failure() {
            self.refuse_all(&fault);
            self.refuse_exports(&fault);
        } else if self.export() {
            // The step behind waits.
        } else if self.queue.is_empty() {
            self.end_finished_streams();
        } else if self.writer_has_room() && self.log.has_room() && self.has_memory() {
            self.dispatch();
        }
        self.show();
    }

    /// Sends the current step's next increment to a solver thread.
    fn dispatch(&mut self) {
        if !matches!(self.place, Place::Home(_)) {
            return;
        }
        let (wanted, every) = (self.wanted(), self.spec.output.every);
        let scratch_bytes = self.scratch_bytes();
        let limit = self.spec.plan.scene().solver.max_wall_time;
        let ceiling = self.services.config.step_time();
        let length = match self.was_long {
            true => Length::Long,
            false => work::length(&self.spec.plan),
        };
        let Some(current) = self.queue.current() else {
            return;
        };
        current.start_clock(limit, &self.events);
        let (traces, sequence) = (&self.services.traces, current.sequence);
        let begin = || traces.update(&self.spec.name, sequence);
        let trace = current.trace.get_or_insert_with(begin).clone();
        current.start_ceiling(ceiling, &self.events);
        let task = Task {
            sequence: current.sequence,
            number: current.step_number(),
            step: current.step.clone(),
            cancel: current.cancel.clone(),
            clock: Arc::clone(&current.slot_clock),
            wanted,
            every,
            scratch_bytes,
            after_event: self.last_event,
            iterations: self.iterations.clone(),
            metrics: Arc::clone(&self.services.metrics),
            trace,
            ledger: self.log.ledger(),
        };
        let handoff = Handoff::default();
        let empty = Place::Away(Arc::clone(&handoff));
        let Place::Home(work) = std::mem::replace(&mut self.place, empty) else {
            return;
        };
        *handoff.lock().unwrap_or_else(PoisonError::into_inner) = Some(work);
        let (span, events) = (tracing::Span::current(), self.events.clone());
        let held = Arc::clone(&self.spec.reservation);
        self.services.solvers.submit(
            self.client.flow(self.number),
            length,
            move |slot| {
                let outcome = span.in_scope(|| work::advance(&handoff, &task, slot));
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
        self.spec.prepared = None;
        let mut work = ready.work;
        if std::mem::take(&mut self.is_stopped_early) {
            work.stop();
        }
        self.place = Place::Home(work);
        self.replayed(ready.replayed);
        self.account();
    }

    fn is_idle(&self) -> bool {
        self.queue.is_empty() && self.writer.is_none() && self.watchers.is_empty()
    }

    /// Stops everything; [`Actor::over`] says when that has happened.
    fn end(&mut self, ending: SessionEnd) {
        let is_interruption = self.log.is_kept() && ending.is_interruption();
        self.ending.get_or_insert(ending);
        self.stop_preparing.cancel();
        if is_interruption {
            return self.interrupt();
        }
        for dropped in self.queue.keep_current() {
            self.reject(dropped.sequence, &self.parting());
        }
        self.cancel(0);
    }

    /// Whether it ends here and comes back out of the data folder.
    fn goes_on_later(&self) -> bool {
        let ending = self.ending.as_ref();
        self.log.is_kept() && ending.is_some_and(SessionEnd::is_interruption)
    }

    fn parting(&self) -> Fault {
        match &self.ending {
            Some(SessionEnd::ShutDown) if !self.log.is_kept() => Fault::ShuttingDown,
            Some(SessionEnd::ShutDown | SessionEnd::Interrupted(None)) => Fault::Interrupted,
            Some(SessionEnd::Interrupted(Some(why))) => Fault::Unwritable(why.to_string()),
            Some(SessionEnd::Expired) => Fault::SessionExpired(self.spec.name.clone()),
            Some(SessionEnd::Deleted | SessionEnd::Died) | None => {
                Fault::SessionDeleted(self.spec.name.clone())
            }
        }
    }

    /// The ending, when nothing runs any more.
    fn over(&mut self) -> Option<SessionEnd> {
        let ending = self.ending.clone().filter(|_| self.queue.is_empty())?;
        self.refuse_exports(&self.parting());
        self.end_streams(&self.parting());
        Some(ending)
    }
}

/// No results yet; with a journal each is shown when the disk has it.
fn kept(services: &Services) -> Kept {
    let config = &services.config;
    let mut kept = Kept::new(config.retained_results, config.retained_field_bytes);
    if services.journal.is_some() {
        kept.show(0);
    }
    kept
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
