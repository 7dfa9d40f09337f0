//! A worker: takes one case after another, solves it and publishes its row before the case
//! leaves the queue.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use async_nats::jetstream::AckKind;
use async_nats::jetstream::Message;
use async_nats::jetstream::consumer::PullConsumer;
use prost::Message as _;
use signorini_proto::v1;
use tokio::sync::{Mutex, watch};
use tokio::task::JoinSet;
use tokio::time::{interval_at, sleep};
use tokio_stream::StreamExt as _;

use super::gauges::Gauges;
use super::{Manifest, PROGRESS_INTERVAL, Queue, broken, depot, parts, post, result_subject};
use crate::studies::row::{FAILED, REFUSED, Row, told};
use crate::studies::server::Server;
use crate::studies::solver::{End, Fields, Job, Stop, meaning, solve};
use crate::terminal::exit::{Failure, panicked};
use crate::terminal::progress::Verbosity;
use crate::terminal::text::note;

/// How long one question for a case stands.
const ASK_LIMIT: Duration = Duration::from_secs(2);
/// Before the queue, or a busy server, is asked again.
const PAUSE: Duration = Duration::from_millis(500);
/// Studies of which a worker remembers what it was told.
const MOST_MANIFESTS: usize = 64;
/// Times that a mesh is uploaded for a case.
const UPLOADS: u32 = 3;

/// What the tasks of a worker share.
pub(crate) struct Worker {
    pub(crate) queue: Queue,
    pub(crate) server: Server,
    pub(crate) fields: Option<Fields>,
    /// Ends without a case for so long.
    pub(crate) idle: Option<Duration>,
    pub(crate) verbosity: Verbosity,
    pub(crate) manifests: Mutex<HashMap<String, Arc<Manifest>>>,
    /// Where somebody looks at them.
    pub(crate) gauges: Option<Arc<Gauges>>,
}

/// A case as it came.
struct Delivery {
    message: Message,
    study: String,
    case: u64,
    id: String,
    /// When, and how many waited after it.
    came: Instant,
    waiting: u64,
    /// Times that it was given out, this one included.
    delivered: u32,
}

/// What becomes of a delivery.
enum Verdict {
    /// Its row is published.
    Done,
    /// Another worker may have it.
    Back,
    /// Nobody wants it any more.
    Unwanted,
}

/// Works on so many cases at one time until it is told to stop, or nothing has come for long.
pub(crate) async fn work(
    worker: Arc<Worker>,
    count: usize,
    stop: &watch::Sender<bool>,
) -> Result<(), Failure> {
    let mut tasks = JoinSet::new();
    for _ in 0..count {
        tasks.spawn(serve(Arc::clone(&worker), stop.subscribe()));
    }
    let mut outcome = Ok(());
    while let Some(ended) = tasks.join_next().await {
        let ended = ended.unwrap_or_else(|error| Err(panicked(&error)));
        if ended.is_err() {
            stop.send_replace(true);
            outcome = outcome.and(ended);
        }
    }
    outcome
}

async fn serve(worker: Arc<Worker>, mut stop: Stop) -> Result<(), Failure> {
    let (mut last, mut consumer) = (Instant::now(), None);
    while !*stop.borrow() {
        if worker.idle.is_some_and(|idle| last.elapsed() > idle) {
            break;
        }
        let message = tokio::select! {
            message = next(&worker.queue, &mut consumer) => message,
            _ = stop.wait_for(|stop| *stop) => break,
        };
        match message {
            Ok(Some(message)) => {
                worker.take(message, &mut stop).await?;
                last = Instant::now();
            }
            Ok(None) => worker.tell(Gauges::idle),
            Err(_) => sleep(PAUSE).await,
        }
    }
    Ok(())
}

/// The next case, if one comes in time. One only is asked for, so that a worker that dies
/// holds up no other case. Who gave none is made again where it is gone.
async fn next(queue: &Queue, known: &mut Option<PullConsumer>) -> Result<Option<Message>, Failure> {
    let consumer = match known.take() {
        Some(consumer) => consumer,
        None => queue.workers().await?,
    };
    let batch = consumer.batch().max_messages(1).expires(ASK_LIMIT);
    let mut messages = batch.messages().await.map_err(broken)?;
    let message = messages.next().await.transpose().map_err(broken)?;
    *known = message.is_some().then_some(consumer);
    Ok(message)
}

impl Worker {
    /// Takes a case, and says that it goes on for as long as it takes.
    async fn take(&self, message: Message, stop: &mut Stop) -> Result<(), Failure> {
        let Some(delivery) = Delivery::of(message) else {
            return Ok(());
        };
        self.tell(|gauges| gauges.came(delivery.waiting));
        let work = self.verdict(&delivery, stop);
        let mut work = std::pin::pin!(work);
        let first = tokio::time::Instant::now() + PROGRESS_INTERVAL;
        let mut signs = interval_at(first, PROGRESS_INTERVAL);
        let verdict = loop {
            tokio::select! {
                verdict = &mut work => break verdict,
                _ = signs.tick() => {
                    // A connection that is broken comes back, or the case is given out again.
                    let _unsaid = delivery.message.ack_with(AckKind::Progress).await;
                }
            }
        };
        let kind = match &verdict {
            Ok(Verdict::Done) => AckKind::Ack,
            Ok(Verdict::Unwanted) => AckKind::Term,
            Ok(Verdict::Back) | Err(_) => AckKind::Nak(None),
        };
        // One that is lost is given out again, and its row is found.
        let _unsaid = delivery.message.ack_with(kind).await;
        self.tell(Gauges::left);
        if let Ok(Verdict::Back) | Err(_) = &verdict {
            self.tell(Gauges::given_back);
        }
        verdict.map(|_| ())
    }

    fn tell(&self, told: impl FnOnce(&Gauges)) {
        if let Some(gauges) = &self.gauges {
            told(gauges);
        }
    }

    async fn verdict(&self, delivery: &Delivery, stop: &mut Stop) -> Result<Verdict, Failure> {
        let Some(manifest) = self.manifest(&delivery.study).await? else {
            return Ok(Verdict::Unwanted);
        };
        if delivery.delivered > 1 && self.has_row(delivery).await {
            return Ok(Verdict::Done);
        }
        let row = match self.row(delivery, &manifest, stop).await? {
            Some(row) => row.after(delivery.delivered.min(manifest.tries)),
            None => return Ok(Verdict::Back),
        };
        if row.termination == FAILED {
            let why = row.message.as_deref().unwrap_or_default();
            note(&format!(
                "given up: case {} of {}: {why}\n",
                row.id, delivery.study
            ));
        }
        post::result(&self.queue, &delivery.study, &row).await?;
        self.tell(|gauges| gauges.done(&row, delivery.came));
        Ok(Verdict::Done)
    }

    async fn manifest(&self, study: &str) -> Result<Option<Arc<Manifest>>, Failure> {
        let mut known = self.manifests.lock().await;
        if let Some(manifest) = known.get(study) {
            return Ok(Some(Arc::clone(manifest)));
        }
        let Some(manifest) = self.queue.patient(|queue| queue.manifest(study)).await? else {
            return Ok(None);
        };
        if known.len() >= MOST_MANIFESTS {
            known.clear();
        }
        let manifest = Arc::new(manifest);
        known.insert(study.to_owned(), Arc::clone(&manifest));
        Ok(Some(manifest))
    }

    /// Whether the row of a case is published. Where that is not found out it is solved again,
    /// to no harm.
    async fn has_row(&self, delivery: &Delivery) -> bool {
        let subject = result_subject(&delivery.study, delivery.case);
        let last = self.queue.results.get_last_raw_message_by_subject(&subject);
        last.await.is_ok()
    }

    /// The row of a case; none where another worker shall have it.
    async fn row(
        &self,
        delivery: &Delivery,
        manifest: &Manifest,
        stop: &mut Stop,
    ) -> Result<Option<Row>, Failure> {
        if delivery.delivered > manifest.tries {
            let why = format!("{} workers ended while they had it", manifest.tries);
            return Ok(Some(delivery.failed("worker_lost", why)));
        }
        let scene = match v1::Scene::decode(delivery.message.payload.clone()) {
            Ok(scene) => scene,
            Err(error) => {
                let row = Row::without(delivery.case, &delivery.id, REFUSED);
                return Ok(Some(row.because("REQUEST_INVALID", error.to_string())));
            }
        };
        if self.verbosity == Verbosity::Verbose {
            let (id, study) = (&delivery.id, &delivery.study);
            note(&format!("begins: case {id} of {study}\n"));
        }
        match self.solve(delivery, manifest, &scene, stop).await {
            End::Row(row) => Ok(Some(row)),
            End::Stopped | End::Busy => Ok(None),
            End::Fault(failure) => Err(failure),
            End::Missing => {
                let why = "the server does not keep the mesh".to_owned();
                Ok(delivery.give_up(manifest, ("MESH_NOT_FOUND".to_owned(), why)))
            }
            End::Lost(error) => {
                let row = delivery.give_up(manifest, told(&error));
                self.server.revive().await?;
                Ok(row)
            }
        }
    }

    /// Solves a case; what its server does not have is fetched.
    async fn solve(
        &self,
        delivery: &Delivery,
        manifest: &Manifest,
        scene: &v1::Scene,
        stop: &mut Stop,
    ) -> End {
        let fields = self.fields.as_ref().filter(|_| manifest.fields);
        let mut uploads = 0;
        loop {
            let client = self.server.client().await;
            let job = Job {
                case: delivery.case,
                id: &delivery.id,
                scene: scene.clone(),
                wanted: &manifest.wanted,
            };
            match solve(&client, job, fields, stop).await {
                End::Missing if uploads < UPLOADS => {
                    uploads += 1;
                    match depot::supply(&self.queue, &client, scene).await {
                        Ok(()) => {}
                        Err(depot::Fault::Store) => sleep(PAUSE).await,
                        Err(depot::Fault::Server(error)) => {
                            return meaning(delivery.case, &delivery.id, error);
                        }
                    }
                }
                End::Busy if !*stop.borrow() => sleep(PAUSE).await,
                end @ (End::Row(_)
                | End::Missing
                | End::Busy
                | End::Lost(_)
                | End::Stopped
                | End::Fault(_)) => return end,
            }
        }
    }
}

impl Delivery {
    /// None for a message that no study has sent.
    fn of(message: Message) -> Option<Self> {
        let (study, case) = parts(&message.subject)?;
        let (study, info) = (study.to_owned(), message.info().ok()?);
        let (delivered, waiting) = (info.delivered, info.pending);
        let delivered = u32::try_from(delivered).unwrap_or(u32::MAX);
        let headers = message.headers.as_ref();
        let id = headers.and_then(|headers| headers.get(super::ID_HEADER));
        let id = id.map_or_else(|| case.to_string(), ToString::to_string);
        Some(Self {
            study,
            case,
            id,
            came: Instant::now(),
            waiting,
            delivered,
            message,
        })
    }

    fn failed(&self, cause: &str, why: String) -> Row {
        Row::without(self.case, &self.id, FAILED).because(cause, why)
    }

    /// Its row where it was given out as often as it may be.
    fn give_up(&self, manifest: &Manifest, (cause, why): (String, String)) -> Option<Row> {
        let is_last = self.delivered >= manifest.tries;
        is_last.then(|| self.failed(&cause, why))
    }
}
