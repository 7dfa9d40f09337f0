//! The thread that writes: one commit for all changes that wait.
//!
//! Where a fence has the changes first, the disk has them up to a second later: what it lacks then
//! is dropped at the next start anyway.

#[cfg(feature = "fleet")]
use std::collections::BTreeMap;
use std::collections::HashSet;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use redb::Durability;

use super::database::{self, Change};
use super::disk::Disk;
use super::error::JournalError;
#[cfg(feature = "fleet")]
use super::fenced::{Fence, encoded, is_own, whole};
use super::{Done, Shelf, Urgency};
use crate::watch::metrics::Metrics;

/// Changes that nobody waits for wait this long for others.
const LINGER: Duration = Duration::from_millis(50);
/// Changes that a fence has may be in memory alone for so long.
#[cfg(feature = "fleet")]
const LAG: Duration = Duration::from_secs(1);
/// Changes of one commit, so that the first of them does not wait for ever.
const MOST_JOBS: usize = 4096;

/// Changes of one session on their way to the disk.
struct Job {
    name: Box<str>,
    changes: Vec<Change>,
    urgency: Urgency,
    done: Done,
    /// It comes from behind the fence.
    #[cfg(feature = "fleet")]
    adopted: bool,
}

/// Where changes go first, once there is one.
#[cfg(feature = "fleet")]
type Fenced = Arc<std::sync::OnceLock<Arc<dyn Fence>>>;

/// The way to the thread.
pub(super) struct Writer {
    #[cfg(feature = "fleet")]
    fence: Fenced,
    jobs: Mutex<Option<Sender<Job>>>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

impl Writer {
    /// Starts the thread.
    pub(super) fn start(
        shelf: Arc<Shelf>,
        disk: &Arc<Disk>,
        metrics: &Arc<Metrics>,
    ) -> std::io::Result<Self> {
        let (sender, receiver) = mpsc::channel();
        let (disk, metrics) = (Arc::clone(disk), Arc::clone(metrics));
        #[cfg(feature = "fleet")]
        let fence = Fenced::default();
        let pen = Pen {
            shelf,
            disk,
            metrics,
            #[cfg(feature = "fleet")]
            fence: Arc::clone(&fence),
        };
        let run = move || pen.run(&receiver);
        let thread = std::thread::Builder::new()
            .name("journal".to_owned())
            .spawn(run)?;
        Ok(Self {
            #[cfg(feature = "fleet")]
            fence,
            jobs: Mutex::new(Some(sender)),
            thread: Mutex::new(Some(thread)),
        })
    }

    pub(super) fn submit(&self, name: &str, changes: Vec<Change>, urgency: Urgency, done: Done) {
        self.send(Job {
            name: name.into(),
            changes,
            urgency,
            done,
            #[cfg(feature = "fleet")]
            adopted: false,
        });
    }

    /// As [`Writer::submit`], of what comes from behind the fence.
    #[cfg(feature = "fleet")]
    pub(super) fn adopt(&self, name: &str, changes: Vec<Change>, done: Done) {
        self.send(Job {
            name: name.into(),
            changes,
            urgency: Urgency::Now,
            done,
            adopted: true,
        });
    }

    /// Puts a fence in front of everything that follows.
    #[cfg(feature = "fleet")]
    pub(super) fn fence(&self, fence: Arc<dyn Fence>) {
        // There is one at most: a server joins one fleet.
        let _first = self.fence.set(fence);
    }

    fn send(&self, job: Job) {
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

/// What the thread works with.
struct Pen {
    shelf: Arc<Shelf>,
    disk: Arc<Disk>,
    metrics: Arc<Metrics>,
    #[cfg(feature = "fleet")]
    fence: Fenced,
}

impl Pen {
    fn run(&self, jobs: &Receiver<Job>) {
        let mut broken = Broken::default();
        #[cfg(feature = "fleet")]
        let mut lag = Lag::default();
        while let Ok(first) = jobs.recv() {
            let batch = broken.refuse(gather(first, jobs));
            #[cfg(feature = "fleet")]
            let batch = self.fenced(batch, &mut broken);
            if batch.is_empty() {
                continue;
            }
            #[cfg(feature = "fleet")]
            let durability = lag.durability(&batch, self.fence.get().is_some());
            #[cfg(not(feature = "fleet"))]
            let durability = Durability::Immediate;
            let outcome = commit(&self.shelf, &batch, durability, &self.metrics);
            if let Err(error) = &outcome {
                self.disk.refused(error);
                tracing::error!(why = error.to_string(), "the journal cannot be written");
                broken.enter(&batch);
            } else {
                self.disk.took();
            }
            // Before anybody hears of it, who may give the session back then.
            #[cfg(feature = "fleet")]
            self.replace(&names(&batch));
            for job in batch {
                (job.done)(outcome.clone());
            }
        }
        #[cfg(feature = "fleet")]
        if lag.since.is_some() {
            // Whoever opens the folder next finds all of it.
            let _unwritten = commit(&self.shelf, &[], Durability::Immediate, &self.metrics);
        }
    }

    /// Lets through what the fence has stored: the changes of each session as one record.
    #[cfg(feature = "fleet")]
    fn fenced(&self, batch: Vec<Job>, broken: &mut Broken) -> Vec<Job> {
        let Some(fence) = self.fence.get() else {
            return batch;
        };
        let mut changes: BTreeMap<&str, Vec<&Change>> = BTreeMap::new();
        for job in batch.iter().filter(|job| !job.adopted) {
            changes.entry(&job.name).or_default().extend(&job.changes);
        }
        let records = changes.into_iter().map(|(name, changes)| {
            let record = encoded(changes.into_iter());
            (name, record)
        });
        let records: Vec<_> = records.filter(|(_, record)| !record.is_empty()).collect();
        let stored = fence.store(&records);
        let refused = records
            .iter()
            .zip(stored)
            .filter_map(|((name, _), stored)| {
                let error = stored.err()?;
                Some(((*name).to_owned(), error))
            });
        let refused: BTreeMap<String, JournalError> = refused.collect();
        let (lost, left): (Vec<_>, Vec<_>) = batch
            .into_iter()
            .partition(|job| !job.adopted && refused.contains_key(&*job.name));
        broken.enter(&lost);
        for job in lost {
            let error = refused.get(&*job.name).cloned();
            (job.done)(error.map_or(Ok(()), Err));
        }
        left
    }

    /// Replaces the records of sessions that have many, or are over.
    #[cfg(feature = "fleet")]
    fn replace(&self, names: &BTreeMap<Box<str>, bool>) {
        let Some(fence) = self.fence.get() else {
            return;
        };
        for (name, is_over) in names {
            if !is_over && !fence.is_whole_due(name) {
                continue;
            }
            match self.shelf.with(|open| database::load(open, name)) {
                Ok(stored) => fence.replace(name, &whole(stored)),
                Err(error) => {
                    let why = error.to_string();
                    tracing::error!(why, "earlier records stay in the stream");
                }
            }
        }
    }
}

/// The sessions of a batch, and whether each is over by it.
#[cfg(feature = "fleet")]
fn names(batch: &[Job]) -> BTreeMap<Box<str>, bool> {
    let own = batch
        .iter()
        .filter(|job| !job.adopted && !job.name.is_empty());
    let is_over = |job: &Job| matches!(job.changes.last(), Some(Change::Delete));
    own.map(|job| (job.name.clone(), is_over(job))).collect()
}

/// What the disk may lack.
#[cfg(feature = "fleet")]
#[derive(Default)]
struct Lag {
    /// Of the oldest commit that it may lack.
    since: Option<Instant>,
}

#[cfg(feature = "fleet")]
impl Lag {
    /// Whether the disk has to have a batch before anybody hears of it: it has where there is
    /// no fence, where something is of this folder alone, and now and then, so that the
    /// database gets its pages back.
    fn durability(&mut self, batch: &[Job], is_fenced: bool) -> Durability {
        let mut changes = batch.iter().flat_map(|job| &job.changes);
        let is_due = self.since.is_some_and(|since| since.elapsed() >= LAG);
        if !is_fenced || is_due || changes.any(is_own) {
            self.since = None;
            return Durability::Immediate;
        }
        self.since.get_or_insert_with(Instant::now);
        Durability::None
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
            if self.0.contains(&job.name) {
                let why = "an earlier change of this session was lost".to_owned();
                (job.done)(Err(JournalError::Unwritable(why)));
            } else {
                left.push(job)
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
        let next = if is_urgent {
            jobs.try_recv().map_err(|_| RecvTimeoutError::Timeout)
        } else {
            jobs.recv_timeout(until.saturating_duration_since(Instant::now()))
        };
        let Ok(job) = next else { break };
        is_urgent |= job.urgency == Urgency::Now;
        batch.push(job);
    }
    batch
}

fn commit(
    shelf: &Shelf,
    batch: &[Job],
    durability: Durability,
    metrics: &Metrics,
) -> Result<(), JournalError> {
    let start = Instant::now();
    let work = |open: &redb::Database| {
        fail::fail_point!("journal-commit", |_| Err(JournalError::Unwritable(
            "failpoint".to_owned()
        )));
        let all = batch.iter().flat_map(|job| {
            let name: &str = &job.name;
            job.changes.iter().map(move |change| (name, change))
        });
        database::commit(open, all, durability)
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

#[cfg(all(test, feature = "fleet"))]
mod tests {
    use super::*;

    fn job(change: Change) -> Job {
        Job {
            name: "sessions/one".into(),
            changes: vec![change],
            urgency: Urgency::Now,
            done: Box::new(|_| {}),
            adopted: false,
        }
    }

    fn waits(lag: &mut Lag, change: Change, is_fenced: bool) -> bool {
        matches!(
            lag.durability(&[job(change)], is_fenced),
            Durability::Immediate
        )
    }

    #[test]
    fn what_the_fleet_has_waits_for_no_disk_and_what_this_folder_has_alone_does() {
        let mut lag = Lag::default();
        assert!(waits(&mut lag, Change::Delete, false));
        assert!(!waits(&mut lag, Change::Delete, true));
        assert!(lag.since.is_some());
        let own = Change::DropMesh("meshes/one".to_owned());
        assert!(waits(&mut lag, own, true));
        assert!(lag.since.is_none());
        lag.since = Instant::now().checked_sub(LAG);
        assert!(waits(&mut lag, Change::Delete, true));
    }
}
