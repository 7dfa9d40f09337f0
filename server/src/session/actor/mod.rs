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
mod ending;
mod export;
mod journal;
mod log;
mod memory;
mod results;
mod saves;
mod solving;
mod stop;
mod streams;
mod updates;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use signorini::Reuse;
use signorini::prepare::Prepared;
use signorini::report::{CancelToken, FieldName};
use signorini_proto::v1 as wire;
use tokio::sync::{Notify, mpsc, oneshot, watch};
use tokio::time::Instant;

use super::handle::{Command, OnDisconnect, Parting, Pulse};
use super::path::Path;
use super::queue::UpdateQueue;
use super::work::{Event, Handoff, ResponseProgress, Work};
use super::{Services, SessionEnd, SessionSpec};
use crate::config::LONGEST_SECONDS;
use crate::door::client_key::ClientKey;
use crate::fault::FailureCause;
use crate::results::iterations::Iterations;
use crate::results::kept::Kept;
use crate::results::readers::{Begin, Fresh, Reader};
use crate::uploads::store::Lease;
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
    on_disconnect: OnDisconnect,
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
    /// Sequence of the step that was left behind last.
    left_behind: i64,
    /// Of the last increment that a solver finished.
    last_report: Option<wire::StepReport>,
    /// The newest result, for readers that see it when the disk has it.
    fresh: Option<Fresh>,
    /// What the data folder knows of the session.
    log: Log,
    /// How the state came about since the solver last knew nothing.
    path: Path,
    prepared: Option<(Lease<Prepared>, Reuse)>,
    state_bytes: u64,
    response: ResponseProgress,
    /// An accepted update may make the response.
    is_response_due: bool,
    expires: Instant,
    /// When the step ends whose client has left and does not come back.
    cancels_at: Option<Instant>,
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
                // Another server may have gone on with it: what is known here may be old.
                Some(_) if actor.is_given_up() => {
                    parting.get_or_init(|| actor.parting());
                }
                Some(command) => actor.command(command),
                // Every handle is gone, so nobody can ask for the session again.
                None => actor.end(SessionEnd::Deleted),
            },
            Some(event) = arrived.recv() => actor.event(event),
            () = room.notified() => actor.feed(None),
            () = passed(actor.cancels_at) => actor.cancel_left(),
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
            cancels_at: None,
            state_bytes: 0,
            response: ResponseProgress::default(),
            is_response_due: false,
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
            left_behind: 0,
            last_report: None,
            fresh: None,
            log: Log::new(services.journal.is_some(), config.retained_results),
            path: Path::default(),
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

    fn command(&mut self, command: Command) {
        if !matches!(command, Command::List(_) | Command::Glance(_)) {
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
            Command::Glance(reply) => answer(reply, self.glance()),
            Command::Handled(reply) => answer(reply, ()),
            Command::Read(request, reply) => answer(reply, self.read(&request)),
            Command::Export(reply) => self.visit(Visit::Export(reply)),
            Command::Save(reply) => self.visit(Visit::Save(reply)),
            Command::Restore(number, reply) => self.visit(Visit::Restore(number, reply)),
            Command::Delete(reply) => {
                self.deleters.push(reply);
                self.end(SessionEnd::Deleted);
            }
            Command::GiveUp => self.give_up(),
            Command::GiveAway(reply) => answer(reply, self.give_away()),
            Command::ShutDown => self.end(SessionEnd::ShutDown),
        }
    }

    fn event(&mut self, event: Event) {
        self.expires = after(self.spec.ttl);
        match event {
            Event::Prepared(Ok(ready)) => self.ready(*ready),
            Event::Prepared(Err(error)) => {
                self.spec.prepared = None;
                if error.is_difference() {
                    self.services.metrics.replay_differences(1);
                }
                tracing::warn!(cause = error.to_string(), "preparation failed");
                self.place = Place::Lost(Loss {
                    why: error.to_string(),
                    cause: error.cause(),
                });
            }
            Event::Advanced(outcome) => self.advanced(outcome),
            Event::Deadline(sequence) => self.deadline(sequence),
            Event::Ceiling(sequence) => self.ceiling(sequence),
            Event::Stuck(sequence) => self.count_stuck(sequence),
            Event::OutOfPatience(sequence) => self.leave_behind(sequence),
            Event::Journalled(mark, outcome) => self.journalled(mark, outcome),
            Event::Exported(outcome) => self.exported(outcome),
        }
    }

    /// Does what can be done next.
    fn proceed(&mut self) {
        self.stop_here();
        if let Some(fault) = self.failure() {
            self.refuse_all(&fault);
            self.refuse_exports(&fault);
        } else if self.export() {
            // The step after waits.
        } else if self.queue.is_empty() {
            self.end_finished_streams();
        } else if self.writer_has_room() && self.log.has_room() && self.has_memory() {
            self.dispatch();
        }
        self.show();
    }

    fn is_idle(&self) -> bool {
        self.queue.is_empty() && self.writer.is_none() && self.watchers.is_empty()
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

/// Returns at that time; never without one.
async fn passed(time: Option<Instant>) {
    match time {
        Some(time) => tokio::time::sleep_until(time).await,
        None => std::future::pending().await,
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
