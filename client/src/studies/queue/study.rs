//! The side of a study: publishes its cases and gathers their rows.

use std::time::{Duration, Instant};

use bytes::Bytes;
use prost::Message as _;
use signorini_client::study::Study;
use tokio::sync::watch;

use super::post::Mail;
use super::rows::Rows;
use super::{Manifest, Queue, broken};
use crate::studies::assets::{AssetFault, Assets};
use crate::studies::ledger::Shared;
use crate::studies::log::Start;
use crate::studies::pool::{unread, unusable};
use crate::studies::row::{REFUSED, Row};
use crate::terminal::exit::Failure;

/// Without a row for so long, and without a case in the queue, cases are published again.
const SILENCE: Duration = Duration::from_secs(10);

/// A study on a queue.
pub(crate) struct Queued<'a> {
    pub(crate) queue: &'a Queue,
    pub(crate) study: &'a Study,
    /// Its name there.
    pub(crate) name: &'a str,
    pub(crate) assets: &'a Assets,
    pub(crate) ledger: &'a Shared,
}

/// Publishes every case that has no row and takes rows until all have one or it is told to
/// stop, which takes the cases back that no worker has.
pub(crate) async fn run(
    queued: &Queued<'_>,
    manifest: &Manifest,
    start: Start,
    stop: &watch::Sender<bool>,
) -> Result<(), Failure> {
    if start == Start::Anew {
        queued.forget().await?;
    }
    let bytes: Bytes = serde_json::to_vec(manifest).map_err(broken)?.into();
    let put = queued.queue.studies.put(queued.name, bytes).await;
    put.map_err(broken)?;
    let mut stopped = stop.subscribe();
    let ended = tokio::select! {
        ended = queued.solve_all() => ended,
        _ = stopped.wait_for(|stop| *stop) => return queued.take_back().await,
    };
    ended?;
    queued.forget().await
}

impl Queued<'_> {
    /// Nothing of the study stays in the queue.
    async fn forget(&self) -> Result<(), Failure> {
        self.take_back().await?;
        self.queue.studies.purge(self.name).await.map_err(broken)?;
        let subjects = format!("signorini.result.{}.*", self.name);
        let purged = self.queue.results.purge().filter(subjects).await;
        purged.map(|_| ()).map_err(broken)
    }

    /// Takes the cases back that are not done.
    async fn take_back(&self) -> Result<(), Failure> {
        let subjects = format!("signorini.case.{}.*", self.name);
        let purged = self.queue.cases.purge().filter(subjects).await;
        purged.map(|_| ()).map_err(broken)
    }

    async fn solve_all(&self) -> Result<(), Failure> {
        let (mut rows, pending) = Rows::open(self.queue, self.name).await?;
        // Rows that are there already belong to cases that need not be published.
        for _ in 0..pending {
            self.take(&mut rows).await?;
        }
        let (publish, gather) = (self.publish(), self.gather(&mut rows));
        let ((), ()) = tokio::try_join!(publish, gather)?;
        Ok(())
    }

    /// Takes the next row; whether one came in time.
    async fn take(&self, rows: &mut Rows<'_>) -> Result<bool, Failure> {
        let Some(row) = rows.next(SILENCE).await? else {
            return Ok(false);
        };
        if row.case < self.study.count() {
            self.ledger.lock().add(&row)?;
        }
        Ok(true)
    }

    fn is_complete(&self) -> bool {
        self.ledger.lock().log().done() >= self.study.count()
    }

    async fn gather(&self, rows: &mut Rows<'_>) -> Result<(), Failure> {
        let mut last = Instant::now();
        while !self.is_complete() {
            if self.take(rows).await? {
                last = Instant::now();
            } else if last.elapsed() >= SILENCE && self.is_queue_empty().await {
                // A case that no worker has and the queue neither is lost with a disk.
                self.publish().await?;
                last = Instant::now();
            }
        }
        Ok(())
    }

    async fn is_queue_empty(&self) -> bool {
        let info = self.queue.cases.get_info().await;
        info.is_ok_and(|info| info.state.messages == 0)
    }

    async fn publish(&self) -> Result<(), Failure> {
        let mut mail = Mail::new(self.queue, self.name);
        for index in 0..self.study.count() {
            let is_done = self.ledger.lock().log().is_done(index);
            let Some(case) = (!is_done).then(|| self.study.case(index)).flatten() else {
                continue;
            };
            let named = match self.study.scene(&case) {
                Ok(file) => self.assets.name(file, self.queue).await,
                Err(error) => {
                    self.ledger.lock().add(&unread(&case, &error))?;
                    continue;
                }
            };
            let scene = match named {
                Ok(scene) => Bytes::from(scene.encode_to_vec()),
                Err(AssetFault::Depot(failure)) => return Err(failure),
                Err(AssetFault::File(failure)) => {
                    self.ledger.lock().add(&unusable(&case, &failure))?;
                    continue;
                }
            };
            let most = self.queue.context.client().server_info().max_payload;
            if scene.len() + 1024 > most {
                let why = format!(
                    "the scene has {} bytes, the queue takes {most}",
                    scene.len()
                );
                let row = Row::without(index, &case.id, REFUSED).because("MESSAGE_LIMIT", why);
                self.ledger.lock().add(&row)?;
                continue;
            }
            mail.send(index, &case.id, scene).await?;
        }
        mail.finish().await
    }
}
