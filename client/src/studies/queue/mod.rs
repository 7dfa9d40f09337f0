//! Cases of studies as messages of NATS JetStream, for workers on any machine.
//!
//! Two streams and two stores hold everything: the stream of cases is a work queue with one
//! subject a case, so that a case waits in it once; the stream of results has one subject a
//! case too, and a result is published with the expected sequence 0 of its subject, so that a
//! case has one result however often it is solved. What is to be known of a study stands in
//! a key-value bucket, meshes and surfaces by digest in an object store. Queue, deliveries and
//! durability are those of NATS; nothing here decides who works on what.

mod depot;
mod gauges;
mod post;
mod rows;
mod study;
mod worker;

use std::future::Future;
use std::time::{Duration, Instant};

use async_nats::ConnectOptions;
use async_nats::jetstream::consumer::{PullConsumer, pull};
use async_nats::jetstream::context::ContextBuilder;
use async_nats::jetstream::stream::{Config, DiscardPolicy, RetentionPolicy, Stream};
use async_nats::jetstream::{Context, kv, object_store};
use serde::{Deserialize, Serialize};
use signorini_client::study::{Study, Wanted};
use tokio::time::sleep;

use crate::arguments::QueueArguments;
use crate::terminal::exit::{Exit, Failure};

pub(crate) use gauges::Gauges;
pub(crate) use study::{Queued, run as run_study};
pub(crate) use worker::{Worker, work};

const CASES: &str = "SIGNORINI_CASES";
const RESULTS: &str = "SIGNORINI_RESULTS";
const STUDIES: &str = "SIGNORINI_STUDIES";
const ASSETS: &str = "SIGNORINI_ASSETS";
/// Name of the consumer that all workers share.
const WORKERS: &str = "workers";

/// After which a case is given to another worker unless its own says that it goes on.
const ACK_WAIT: Duration = Duration::from_secs(10);
/// How often a worker says so.
const PROGRESS_INTERVAL: Duration = Duration::from_secs(3);
/// In which NATS knows the identifiers of cases that it got.
const DUPLICATE_WINDOW: Duration = Duration::from_secs(3600);
/// Cases that all workers may have at one time.
const MOST_IN_WORK: i64 = 100_000;
/// How long a request to the queue may take.
const ANSWER_LIMIT: Duration = Duration::from_secs(5);

/// Copies that a cluster keeps of everything; who names as many servers has a cluster.
const COPIES: usize = 3;

/// Header with the identifier of a case.
const ID_HEADER: &str = "Signorini-Case";
/// How long the queue is tried again after it broke.
const PATIENCE: Duration = Duration::from_secs(300);
/// Before it is.
const PAUSE: Duration = Duration::from_millis(500);

/// What workers are told of a study.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub(crate) struct Manifest {
    pub(crate) wanted: Vec<Wanted>,
    /// Times that a case is given out at most.
    pub(crate) tries: u32,
    /// Whether fields are wanted of workers that have a folder for them.
    pub(crate) fields: bool,
}

/// A queue that is there.
#[derive(Clone)]
pub(crate) struct Queue {
    context: Context,
    cases: Stream,
    results: Stream,
    studies: kv::Store,
    assets: object_store::ObjectStore,
}

/// What went wrong with the queue.
pub(crate) fn broken(error: impl std::fmt::Display) -> Failure {
    Failure::new(Exit::NoServer, format!("the queue: {error}"))
}

/// Name of a study with its mesh.
pub(crate) fn name_of(study: &Study, mesh: &str) -> String {
    let digest: String = mesh
        .trim_start_matches("meshes/")
        .chars()
        .take(12)
        .collect();
    format!("{}-{digest}", study.digest())
}

/// Subject of a case.
fn case_subject(study: &str, case: u64) -> String {
    format!("signorini.case.{study}.{case}")
}

/// Subject of its result.
fn result_subject(study: &str, case: u64) -> String {
    format!("signorini.result.{study}.{case}")
}

/// Study and number of the case that a subject is of.
fn parts(subject: &str) -> Option<(&str, u64)> {
    let rest = subject.strip_prefix("signorini.case.")?;
    let (study, case) = rest.split_once('.')?;
    Some((study, case.parse().ok()?))
}

impl Queue {
    /// Connects, and makes what is not there yet.
    pub(crate) async fn open(arguments: &QueueArguments, url: &str) -> Result<Self, Failure> {
        let mut options = ConnectOptions::new().name("signorini");
        if let Some(path) = &arguments.queue_credentials {
            let read = options.credentials_file(path).await;
            options = read.map_err(|error| Failure::unreadable(path, &error))?;
        }
        let addresses = signorini_server::nats_addresses(url);
        let client = options.connect(addresses.as_slice()).await;
        let client = client.map_err(|error| broken(format!("{url}: {error}")))?;
        let context = ContextBuilder::new().timeout(ANSWER_LIMIT).build(client);
        let copies = copies(addresses.len());
        let cases = context.get_or_create_stream(Config {
            retention: RetentionPolicy::WorkQueue,
            duplicate_window: DUPLICATE_WINDOW,
            ..stream(CASES, "signorini.case.*.*", copies)
        });
        let cases = cases.await.map_err(broken)?;
        let results = stream(RESULTS, "signorini.result.*.*", copies);
        let results = context.get_or_create_stream(results);
        let results = results.await.map_err(broken)?;
        Ok(Self {
            studies: studies(&context, copies).await?,
            assets: assets(&context, copies).await?,
            cases,
            results,
            context,
        })
    }

    /// The consumer that gives cases to workers.
    async fn workers(&self) -> Result<PullConsumer, Failure> {
        let config = pull::Config {
            durable_name: Some(WORKERS.to_owned()),
            ack_wait: ACK_WAIT,
            // Who gives a case up says so itself, with its cause.
            max_deliver: -1,
            max_ack_pending: MOST_IN_WORK,
            ..Default::default()
        };
        let consumer = self.cases.get_or_create_consumer(WORKERS, config);
        consumer.await.map_err(broken)
    }

    /// The answer to a question that is asked again while the queue is broken.
    async fn patient<'a, T, F>(&'a self, ask: impl Fn(&'a Self) -> F) -> Result<T, Failure>
    where
        F: Future<Output = Result<T, Failure>>,
    {
        let begun = Instant::now();
        loop {
            match ask(self).await {
                Err(_) if begun.elapsed() < PATIENCE => sleep(PAUSE).await,
                answer => return answer,
            }
        }
    }

    /// What is told of a study, while it is under way.
    async fn manifest(&self, study: &str) -> Result<Option<Manifest>, Failure> {
        let bytes = self.studies.get(study).await.map_err(broken)?;
        bytes
            .map(|bytes| serde_json::from_slice(&bytes).map_err(broken))
            .transpose()
    }
}

/// The bucket is made as the stream that it is: what the crate asks about the account first is
/// not all answered by NATS 2.9. Its leader alone answers: a copy that lags behind would say of a
/// study that it is over.
async fn studies(context: &Context, copies: usize) -> Result<kv::Store, Failure> {
    let config = Config {
        max_messages_per_subject: 1,
        discard: DiscardPolicy::New,
        allow_rollup: true,
        deny_delete: true,
        ..stream(
            &format!("KV_{STUDIES}"),
            &format!("$KV.{STUDIES}.>"),
            copies,
        )
    };
    context.get_or_create_stream(config).await.map_err(broken)?;
    context.get_key_value(STUDIES).await.map_err(broken)
}

/// One that is there stays as it was made.
async fn assets(context: &Context, copies: usize) -> Result<object_store::ObjectStore, Failure> {
    if let Ok(store) = context.get_object_store(ASSETS).await {
        return Ok(store);
    }
    let config = object_store::Config {
        bucket: ASSETS.to_owned(),
        num_replicas: copies,
        ..Default::default()
    };
    context.create_object_store(config).await.map_err(broken)
}

fn copies(addresses: usize) -> usize {
    if addresses >= COPIES { COPIES } else { 1 }
}

fn stream(name: &str, subject: &str, copies: usize) -> Config {
    Config {
        name: name.to_owned(),
        subjects: vec![subject.to_owned()],
        num_replicas: copies,
        ..Default::default()
    }
}
