//! The cases of a study on one server, several at one time.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use signorini_client::scene_file::SceneFileError;
use signorini_client::study::{Case, Study};
use signorini_proto::v1;
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::sleep;

use super::assets::{AssetFault, Assets, Depot};
use super::ledger::Shared;
use super::row::{self, FAILED, REFUSED, Row};
use super::server::Server;
use super::solver::{End, Fields, Job, Stop, meaning, solve};
use crate::terminal::exit::{Exit, Failure};

/// Before a server that is busy is asked again; doubles.
const FIRST_PAUSE: Duration = Duration::from_millis(100);
const LONGEST_PAUSE: Duration = Duration::from_secs(5);

/// What workers share.
pub(crate) struct Local {
    pub(crate) study: Study,
    pub(crate) server: Server,
    pub(crate) assets: Assets,
    pub(crate) fields: Option<Fields>,
    /// Times that a case is begun at most.
    pub(crate) tries: u32,
}

impl Local {
    /// For a study on a server; fields go into folders of `fields`.
    pub(crate) fn new(study: Study, server: Server, fields: Option<PathBuf>, tries: u32) -> Self {
        Self {
            study,
            server,
            assets: Assets::default(),
            fields: fields.map(Fields::new),
            tries,
        }
    }
}

impl Local {
    /// The scene of the first case that can be read, on its server.
    pub(crate) async fn first_scene(&self) -> Result<v1::Scene, Failure> {
        let client = self.server.client().await;
        first_scene(&self.study, &self.assets, &client).await
    }
}

/// The scene of the first case of which every file can be read, its files handed on.
pub(crate) async fn first_scene<D: Depot>(
    study: &Study,
    assets: &Assets,
    depot: &D,
) -> Result<v1::Scene, Failure>
where
    Failure: From<D::Error>,
{
    let mut why = None;
    for file in study.readable() {
        match assets.name(file, depot).await {
            Ok(scene) => return Ok(scene),
            Err(AssetFault::File(failure)) => why = why.or(Some(failure)),
            Err(AssetFault::Depot(error)) => why = why.or(Some(error.into())),
        }
    }
    Err(why.unwrap_or_else(|| Failure::new(Exit::Invalid, "no case can be read")))
}

/// Solves every case that has no row yet, until all have one or it is told to stop.
pub(crate) async fn run(
    local: Arc<Local>,
    ledger: Shared,
    workers: usize,
    stop: &watch::Sender<bool>,
) -> Result<(), Failure> {
    let next = Arc::new(AtomicU64::new(0));
    let mut tasks = JoinSet::new();
    for _ in 0..workers {
        let worker = Worker {
            local: Arc::clone(&local),
            ledger: ledger.clone(),
            next: Arc::clone(&next),
            stop: stop.subscribe(),
        };
        tasks.spawn(worker.work());
    }
    let mut outcome = Ok(());
    while let Some(ended) = tasks.join_next().await {
        let ended = ended.unwrap_or_else(|error| Err(crate::terminal::exit::panicked(&error)));
        if ended.is_err() {
            stop.send_replace(true);
            outcome = outcome.and(ended);
        }
    }
    outcome
}

struct Worker {
    local: Arc<Local>,
    ledger: Shared,
    next: Arc<AtomicU64>,
    stop: Stop,
}

impl Worker {
    async fn work(mut self) -> Result<(), Failure> {
        while !*self.stop.borrow() {
            let index = self.next.fetch_add(1, Ordering::Relaxed);
            let Some(case) = self.case(index) else {
                if index >= self.local.study.count() {
                    break;
                }
                continue;
            };
            if let Some(row) = self.attempt_all(&case).await? {
                self.ledger.lock().add(&row)?;
            }
        }
        Ok(())
    }

    /// The case, unless it has its row.
    fn case(&self, index: u64) -> Option<Case> {
        let is_done = self.ledger.lock().log().is_done(index);
        (!is_done).then(|| self.local.study.case(index))?
    }

    /// Begins a case until it has a row, or as often as it may; none when it is to stop.
    async fn attempt_all(&mut self, case: &Case) -> Result<Option<Row>, Failure> {
        let told = |cause: &str, why: &str| (cause.to_owned(), why.to_owned());
        let (mut cause, mut why) = told("process_ended", "the process ended each time");
        let mut attempts = self.ledger.lock().log().begun(case.index);
        while attempts < self.local.tries {
            attempts += 1;
            self.ledger.lock().log().begin(case.index)?;
            (cause, why) = match self.attempt(case).await {
                End::Row(row) => return Ok(Some(row.after(attempts))),
                End::Stopped => return Ok(None),
                End::Fault(failure) => return Err(failure),
                End::Missing => told("MESH_NOT_FOUND", "the server does not keep the mesh"),
                End::Busy => told("QUEUE_FULL", "the server is busy"),
                End::Lost(error) => {
                    self.local.server.revive().await?;
                    row::told(&error)
                }
            };
        }
        let row = Row::without(case.index, &case.id, FAILED).because(&cause, why);
        Ok(Some(row.after(attempts)))
    }

    /// Waits while the server is busy; uploads again what it has lost.
    async fn attempt(&mut self, case: &Case) -> End {
        let (mut pause, mut uploads) = (FIRST_PAUSE, 0);
        loop {
            match self.once(case).await {
                End::Missing if uploads < 3 => {
                    uploads += 1;
                    self.local.assets.forget().await;
                }
                End::Busy => {
                    tokio::select! {
                        () = sleep(pause) => pause = (pause * 2).min(LONGEST_PAUSE),
                        _ = self.stop.wait_for(|stop| *stop) => return End::Stopped,
                    }
                }
                end
                @ (End::Row(_) | End::Missing | End::Lost(_) | End::Stopped | End::Fault(_)) => {
                    return end;
                }
            }
        }
    }

    async fn once(&mut self, case: &Case) -> End {
        let local = &self.local;
        let file = match local.study.scene(case) {
            Ok(file) => file,
            Err(error) => return End::Row(unread(case, &error)),
        };
        let client = local.server.client().await;
        let scene = match local.assets.name(file, &client).await {
            Ok(scene) => scene,
            Err(AssetFault::File(failure)) => return End::Row(unusable(case, &failure)),
            Err(AssetFault::Depot(error)) => return meaning(case.index, &case.id, error),
        };
        let job = Job {
            case: case.index,
            id: &case.id,
            scene,
            wanted: local.study.wanted(),
        };
        solve(&client, job, local.fields.as_ref(), &mut self.stop).await
    }
}

/// The row of a case whose scene cannot be read.
pub(crate) fn unread(case: &Case, error: &SceneFileError) -> Row {
    Row::without(case.index, &case.id, REFUSED).because("SCENE_INVALID", error.to_string())
}

/// The row of a case that names a file that cannot be used.
pub(crate) fn unusable(case: &Case, failure: &Failure) -> Row {
    Row::without(case.index, &case.id, REFUSED).because("FILE", failure.text())
}
