//! The thread that writes: one commit for all changes that wait.

use std::collections::HashSet;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::database::{self, Change};
use super::error::JournalError;
use super::{Done, Shelf, Urgency};
use crate::metrics::Metrics;

/// Changes that nobody waits for wait this long for others.
const LINGER: Duration = Duration::from_millis(50);
/// Changes of one commit, so that the first of them does not wait for ever.
const MOST_JOBS: usize = 4096;

/// Changes of one session on their way to the disk.
struct Job {
    name: Box<str>,
    changes: Vec<Change>,
    urgency: Urgency,
    done: Done,
}

/// The way to the thread.
pub(super) struct Writer {
    jobs: Mutex<Option<Sender<Job>>>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

impl Writer {
    /// Starts the thread.
    pub(super) fn start(shelf: Arc<Shelf>, metrics: &Arc<Metrics>) -> std::io::Result<Self> {
        let (sender, receiver) = mpsc::channel();
        let metrics = Arc::clone(metrics);
        let run = move || run(&shelf, &receiver, &metrics);
        let thread = std::thread::Builder::new()
            .name("journal".to_owned())
            .spawn(run)?;
        Ok(Self {
            jobs: Mutex::new(Some(sender)),
            thread: Mutex::new(Some(thread)),
        })
    }

    pub(super) fn submit(&self, name: &str, changes: Vec<Change>, urgency: Urgency, done: Done) {
        let job = Job {
            name: name.into(),
            changes,
            urgency,
            done,
        };
        let jobs = self.jobs.lock().unwrap_or_else(PoisonError::into_inner);
        let refused = match jobs.as_ref() {
            Some(sender) => sender.send(job).err().map(|error| error.0),
            None => Some(job),
        };
        drop(jobs);
        if let Some(job) = refused {
            let why = "the server is shutting down".to_owned();
            (job.done)(Err(JournalError::Unwritable(why)));
        }
    }

    /// Waits until everything is written.
    pub(super) fn close(&self) {
        *self.jobs.lock().unwrap_or_else(PoisonError::into_inner) = None;
        let thread = self
            .thread
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if thread.is_some_and(|thread| thread.join().is_err()) {
            tracing::error!("the journal ended by a panic");
        }
    }
}

fn run(shelf: &Shelf, jobs: &Receiver<Job>, metrics: &Metrics) {
    let mut broken = Broken::default();
    while let Ok(first) = jobs.recv() {
        let batch = broken.refuse(gather(first, jobs));
        if batch.is_empty() {
            continue;
        }
        let outcome = commit(shelf, &batch, metrics);
        if let Err(error) = &outcome {
            metrics.journal_failed();
            tracing::error!(why = error.to_string(), "the journal cannot be written");
            broken.enter(&batch);
        }
        for job in batch {
            (job.done)(outcome.clone());
        }
    }
}

/// Sessions of which a change was lost: later ones would leave a gap.
#[derive(Default)]
struct Broken(HashSet<Box<str>>);

impl Broken {
    /// Refuses the changes of such sessions, but for one that begins anew.
    fn refuse(&mut self, batch: Vec<Job>) -> Vec<Job> {
        let mut left = Vec::with_capacity(batch.len());
        for job in batch {
            if matches!(job.changes.first(), Some(Change::Begin)) {
                self.0.remove(&job.name);
            }
            match self.0.contains(&job.name) {
                true => {
                    let why = "an earlier change of this session was lost".to_owned();
                    (job.done)(Err(JournalError::Unwritable(why)));
                }
                false => left.push(job),
            }
        }
        left
    }

    fn enter(&mut self, batch: &[Job]) {
        let names = batch.iter().map(|job| job.name.clone());
        // What has no name belongs to no session.
        self.0.extend(names.filter(|name| !name.is_empty()));
    }
}

/// All jobs that wait; those that nobody waits for wait a moment for others.
fn gather(first: Job, jobs: &Receiver<Job>) -> Vec<Job> {
    let until = Instant::now() + LINGER;
    let mut is_urgent = first.urgency == Urgency::Now;
    let mut batch = vec![first];
    while batch.len() < MOST_JOBS {
        let next = match is_urgent {
            true => jobs.try_recv().map_err(|_| RecvTimeoutError::Timeout),
            false => jobs.recv_timeout(until.saturating_duration_since(Instant::now())),
        };
        let Ok(job) = next else { break };
        is_urgent |= job.urgency == Urgency::Now;
        batch.push(job);
    }
    batch
}

fn commit(shelf: &Shelf, batch: &[Job], metrics: &Metrics) -> Result<(), JournalError> {
    let start = Instant::now();
    let work = |open: &redb::Database| {
        fail::fail_point!("journal-commit", |_| Err(JournalError::Unwritable(
            "failpoint".to_owned()
        )));
        let all = batch.iter().flat_map(|job| {
            let name: &str = &job.name;
            job.changes.iter().map(move |change| (name, change))
        });
        database::commit(open, all)
    };
    let outcome = shelf.with(work);
    let bytes = match outcome {
        Ok(bytes) => bytes,
        Err(error) => {
            // A database that failed once refuses everything until it is opened again.
            if let Err(again) = shelf.reopen() {
                tracing::error!(why = again.to_string(), "the journal cannot be opened");
            }
            return Err(error);
        }
    };
    metrics.journal_commit(start.elapsed(), bytes);
    Ok(())
}
