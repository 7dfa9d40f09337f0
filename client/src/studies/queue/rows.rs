//! Rows of a study from the stream of results, in order, each once, over breaks of the queue.
//!
//! The consumer that reads them holds no state of its own: one that is gone, with a restart of
//! NATS say, is replaced by another that begins after the last row that came.

use std::time::{Duration, Instant};

use async_nats::jetstream::consumer::pull::{Batch, Config};
use async_nats::jetstream::consumer::{AckPolicy, DeliverPolicy, PullConsumer};
use bytes::Bytes;
use tokio::time::{sleep, timeout};
use tokio_stream::StreamExt as _;

use super::{PATIENCE, PAUSE, Queue, broken};
use crate::studies::row::Row;
use crate::terminal::exit::Failure;

/// Rows that NATS sends at one time.
const BATCH: usize = 500;
/// How long one question for rows stands.
const ASK_LIMIT: Duration = Duration::from_secs(2);
/// How long a consumer lives that nobody asks.
const INACTIVE: Duration = Duration::from_secs(300);

/// Where the rows of a study are read.
pub(super) struct Rows<'a> {
    queue: &'a Queue,
    subjects: String,
    /// Of the stream, after the last row.
    next: u64,
    consumer: Option<PullConsumer>,
    batch: Option<Batch>,
}

impl<'a> Rows<'a> {
    /// From the first row on, and how many there are.
    pub(super) async fn open(queue: &'a Queue, study: &str) -> Result<(Self, u64), Failure> {
        let mut rows = Self {
            queue,
            subjects: format!("signorini.result.{study}.*"),
            next: 1,
            consumer: None,
            batch: None,
        };
        let consumer = rows.consumer().await?;
        let pending = consumer.cached_info().num_pending;
        rows.consumer = Some(consumer);
        Ok((rows, pending))
    }

    async fn consumer(&self) -> Result<PullConsumer, Failure> {
        let config = Config {
            filter_subject: self.subjects.clone(),
            deliver_policy: DeliverPolicy::ByStartSequence {
                start_sequence: self.next,
            },
            ack_policy: AckPolicy::None,
            inactive_threshold: INACTIVE,
            ..Default::default()
        };
        let created = self.queue.results.create_consumer(config).await;
        created.map_err(broken)
    }

    /// The next row; none when none came in time.
    pub(super) async fn next(&mut self, limit: Duration) -> Result<Option<Row>, Failure> {
        let (begun, mut broken_since) = (Instant::now(), None);
        while begun.elapsed() < limit || broken_since.is_some() {
            match self.ask().await {
                Ok(Some(row)) => return serde_json::from_slice(&row).map(Some).map_err(broken),
                Ok(None) => broken_since = None,
                Err(failure) => {
                    (self.consumer, self.batch) = (None, None);
                    if broken_since.get_or_insert_with(Instant::now).elapsed() > PATIENCE {
                        return Err(failure);
                    }
                    sleep(PAUSE).await;
                }
            }
        }
        Ok(None)
    }

    /// A row of the batch that is on its way, or of the next; none at the end of one.
    async fn ask(&mut self) -> Result<Option<Bytes>, Failure> {
        let mut batch = match self.batch.take() {
            Some(batch) => batch,
            None => self.batch().await?,
        };
        let next = timeout(ASK_LIMIT * 2, batch.next());
        let next = next.await.map_err(|_| broken("does not answer"))?;
        let Some(message) = next.transpose().map_err(broken)? else {
            return Ok(None);
        };
        self.batch = Some(batch);
        self.next = message.info().map_err(broken)?.stream_sequence + 1;
        Ok(Some(message.message.payload))
    }

    async fn batch(&mut self) -> Result<Batch, Failure> {
        let consumer = match self.consumer.take() {
            Some(consumer) => consumer,
            None => self.consumer().await?,
        };
        let batch = consumer.batch().max_messages(BATCH).expires(ASK_LIMIT);
        let batch = batch.messages().await.map_err(broken)?;
        self.consumer = Some(consumer);
        Ok(batch)
    }
}
