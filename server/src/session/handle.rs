//! The way to a session's actor.

use std::sync::{Arc, OnceLock};
use std::time::Duration;

use signorini::report::FieldName;
use signorini_proto::v1 as wire;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::Instant;

use super::glance::Glance;
use crate::convert::field::Encoding;
use crate::convert::step::Update;
use crate::door::client_key::ClientKey;
use crate::fault::Fault;
use crate::journal::StoredSave;
use crate::results::iterations::IterationReader;
use crate::results::kept::KeptResult;
use crate::results::outbox::Outbox;

/// Updates that may wait between a stream and its actor.
const INBOX: usize = 16;

/// What a stream asks for when it opens.
pub(crate) struct OpenRequest {
    pub(crate) last_seen_event: Option<i64>,
    /// Empty: those of the scene.
    pub(crate) fields: Vec<FieldName>,
    pub(crate) encoding: Encoding,
    pub(crate) max_unread_bytes: u64,
    pub(crate) iteration_interval: Duration,
    pub(crate) role: Role,
}

/// What the end of a stream means for the step that runs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OnDisconnect {
    pub(crate) policy: wire::DisconnectPolicy,
    /// For another stream to come before the step is cancelled.
    pub(crate) grace: Duration,
}

/// What a stream may do.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Role {
    Writer {
        client: ClientKey,
        on_disconnect: OnDisconnect,
        /// Of the whole stream and of what it asks for.
        deadline: Option<Instant>,
    },
    Watcher {
        until: wire::WatchEnd,
    },
}

/// State and running sequence, for heartbeats.
pub(crate) type Pulse = (wire::SessionState, i64);

/// A stream attached to a session.
pub(crate) struct Attachment {
    /// Of the stream in its session.
    pub(crate) number: u64,
    pub(crate) outbox: Arc<Outbox>,
    pub(crate) iterations: IterationReader,
    pub(crate) pulse: watch::Receiver<Pulse>,
}

/// Which results to read again.
pub(crate) struct ReadRequest {
    pub(crate) sequence: i64,
    /// 0: all.
    pub(crate) increment: i32,
}

/// Results read again, with the fields of the scene's output.
pub(crate) struct ReadAnswer {
    pub(crate) results: Vec<Arc<KeptResult>>,
    pub(crate) output: Vec<FieldName>,
}

/// What can be asked of an actor.
pub(crate) enum Command {
    Attach(Box<OpenRequest>, oneshot::Sender<Result<Attachment, Fault>>),
    Detach(u64),
    HalfClose(u64),
    Update(u64, Box<Update>),
    Reject(u64, i64, Fault),
    CancelFrom(u64, i64),
    Cancel(i64, oneshot::Sender<i64>),
    Describe(oneshot::Sender<wire::Session>),
    /// As `Describe`, without renewing the time to live.
    List(oneshot::Sender<wire::Session>),
    /// What it does, without renewing the time to live.
    Glance(oneshot::Sender<Glance>),
    /// Answered when every command before it is handled.
    Handled(oneshot::Sender<()>),
    Read(ReadRequest, oneshot::Sender<Result<ReadAnswer, Fault>>),
    /// The state between two steps, when there is one.
    Export(oneshot::Sender<Result<StoredSave, Fault>>),
    /// Keeps it; the number of the kept one and its bytes.
    Save(oneshot::Sender<Result<(i64, u64), Fault>>),
    /// Puts a kept one in its place.
    Restore(i64, oneshot::Sender<Result<(), Fault>>),
    Delete(oneshot::Sender<()>),
    /// It is another server's.
    GiveUp,
    /// It may be another server's if nobody writes to it; whether it is.
    GiveAway(oneshot::Sender<bool>),
    ShutDown,
}

/// A session, as services see it; clones are the same session.
#[derive(Clone)]
pub(crate) struct Handle {
    name: Arc<str>,
    scene: Arc<wire::Scene>,
    inbox: mpsc::Sender<Command>,
    parting: Parting,
}

/// What an actor that has ended leaves for those who still ask.
pub(super) type Parting = Arc<OnceLock<Fault>>;

impl Handle {
    pub(crate) fn new(name: &str, scene: &Arc<wire::Scene>) -> (Self, mpsc::Receiver<Command>) {
        let (inbox, commands) = mpsc::channel(INBOX);
        let (name, scene) = (Arc::from(name), Arc::clone(scene));
        let handle = Self {
            name,
            scene,
            inbox,
            parting: Parting::default(),
        };
        (handle, commands)
    }

    /// Where the actor leaves its last word.
    pub(super) fn parting(&self) -> Parting {
        Arc::clone(&self.parting)
    }

    /// The scene as the session was created.
    pub(crate) fn scene(&self) -> wire::Scene {
        wire::Scene::clone(&self.scene)
    }

    /// Returns when the actor is over.
    pub(crate) async fn ended(&self) {
        self.inbox.closed().await;
    }

    pub(crate) async fn attach(&self, request: OpenRequest) -> Result<Attachment, Fault> {
        self.ask(|reply| Command::Attach(Box::new(request), reply))
            .await?
    }

    /// Current description.
    pub(crate) async fn describe(&self) -> Result<wire::Session, Fault> {
        self.ask(Command::Describe).await
    }

    /// Current description; the session may expire as if nobody had asked.
    pub(crate) async fn list(&self) -> Result<wire::Session, Fault> {
        self.ask(Command::List).await
    }

    /// What it does just now; the session may expire as if nobody had asked.
    pub(crate) async fn glance(&self) -> Result<Glance, Fault> {
        self.ask(Command::Glance).await
    }

    /// Returns when every command sent before is handled.
    pub(crate) async fn handled(&self) {
        // An actor that is over handles nothing more.
        let _over = self.ask(Command::Handled).await;
    }

    /// Cancels a step, 0 for the current; returns its sequence or 0.
    pub(crate) async fn cancel(&self, sequence: i64) -> Result<i64, Fault> {
        self.ask(|reply| Command::Cancel(sequence, reply)).await
    }

    /// Kept results.
    pub(crate) async fn read(&self, request: ReadRequest) -> Result<ReadAnswer, Fault> {
        self.ask(|reply| Command::Read(request, reply)).await?
    }

    /// The state between two steps, on disk where there is a data folder.
    pub(crate) async fn export(&self) -> Result<StoredSave, Fault> {
        self.ask(Command::Export).await?
    }

    /// Keeps the state between two steps; the number of the kept one and its bytes.
    pub(crate) async fn save(&self) -> Result<(i64, u64), Fault> {
        self.ask(Command::Save).await?
    }

    /// Goes back to a kept state between two steps.
    pub(crate) async fn restore(&self, number: i64) -> Result<(), Fault> {
        self.ask(|reply| Command::Restore(number, reply)).await?
    }

    /// Ends the session.
    pub(crate) async fn delete(&self) -> Result<(), Fault> {
        self.ask(Command::Delete).await
    }

    /// Stops what runs and ends without a further word: the session is another server's.
    pub(crate) fn give_up(&self) {
        self.post(Command::GiveUp);
    }

    /// As [`Handle::give_up`], unless somebody writes to it; whether it does.
    pub(crate) async fn give_away(&self) -> bool {
        self.ask(Command::GiveAway).await.unwrap_or(false)
    }

    /// Stops what runs, delivers it and ends.
    pub(crate) async fn shut_down(&self) {
        self.send(Command::ShutDown).await;
    }

    pub(crate) async fn send(&self, command: Command) {
        // An actor that is over has told its stream why.
        let _over = self.inbox.send(command).await;
    }

    /// Sends from where nothing can wait.
    pub(crate) fn post(&self, command: Command) {
        let Err(mpsc::error::TrySendError::Full(command)) = self.inbox.try_send(command) else {
            return;
        };
        if let Ok(runtime) = tokio::runtime::Handle::try_current() {
            let handle = self.clone();
            runtime.spawn(async move { handle.send(command).await });
        }
    }

    async fn ask<T>(
        &self,
        command: impl FnOnce(oneshot::Sender<T>) -> Command,
    ) -> Result<T, Fault> {
        let (reply, answer) = oneshot::channel();
        self.send(command(reply)).await;
        answer.await.map_err(|_| {
            let said = self.parting.get().cloned();
            said.unwrap_or_else(|| Fault::SessionDeleted(self.name.to_string()))
        })
    }
}
