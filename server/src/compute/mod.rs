//! The solver threads: a fixed number of slots, fed by one queue that is fair between
//! clients, between the connections of one and between the sessions of those; what a client has
//! left running counts as one connection more.
//!
//! A job is the building of prepared data or one increment of one session, so
//! sessions take turns. A job that runs long gives its slot back between iterations
//! when somebody waits who had less ([`Slot::pause`]): its thread sleeps with all it
//! has, so that its bits do not depend on it. Some slots take no long work at all, so
//! that short work never waits for an iteration of a large body. A slot that has ended
//! a job waits a moment for the same session's next one before it serves one that has
//! more running: the result has to reach its reader before the next increment may
//! start. A panic in a job is caught and reported; the process lives. No job waits for
//! a socket.
//!
//! | file | what it does |
//! |---|---|
//! | `fair_queue` | start-time fair queueing over a tree of clients, connections, sessions |
//! | `queue` | jobs that wait, and which one a slot takes |
//! | `seats` | slots that clients hold |

mod fair_queue;
mod queue;
mod seats;

use std::any::Any;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::config::Slots;
use crate::door::client_key::{ClientIdentity, Flow, Share};
use crate::watch::metrics::Metrics;
use queue::{JobQueue, Turn};

/// A job that took so long is long work.
pub(crate) const LONG: Duration = Duration::from_millis(500);

/// How long a job keeps its slot at least.
const QUANTUM: Duration = Duration::from_millis(20);

type Job = Box<dyn FnOnce(&Slot) + Send>;

/// How much the solver threads have to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Load {
    /// Slots that there are.
    pub(crate) slots: usize,
    /// Those of them at work.
    pub(crate) busy: usize,
    /// Jobs that wait for one.
    pub(crate) waiting: usize,
}

/// How long a job will take, as far as is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Length {
    Short,
    Long,
}

/// A slot, as the job that has it sees it.
pub(crate) struct Slot {
    queue: Arc<JobQueue>,
    flow: Flow,
    turn: Mutex<Turn>,
}

impl Slot {
    /// Shows how far the running step is from its equilibrium.
    pub(crate) fn show_residual(&self, residual: f64) {
        if let Some(slot) = self.lock().slot {
            self.queue.show_residual(slot, residual);
        }
    }

    /// Gives the slot to somebody who had less and waits for the next one, or until
    /// the job is `stopped`, which may end without a slot; returns the time that took.
    pub(crate) fn pause(&self, stopped: &dyn Fn() -> bool) -> Duration {
        let mut turn = self.lock();
        match turn.slot {
            Some(_) if turn.since.elapsed() >= QUANTUM => {
                JobQueue::pause(&self.queue, &self.flow, &mut turn, stopped)
            }
            Some(_) | None => Duration::ZERO,
        }
    }

    fn lock(&self) -> MutexGuard<'_, Turn> {
        // Held by the one thread of the job that reports.
        self.turn.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A job panicked; holds what it said.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Panicked(pub(crate) String);

/// The solver threads.
pub(crate) struct SolverThreads {
    queue: Arc<JobQueue>,
    sessions: AtomicU64,
}

impl SolverThreads {
    /// Starts the threads of all slots.
    ///
    /// # Errors
    /// When the system gives no more threads.
    pub(crate) fn start(slots: Slots, metrics: &Arc<Metrics>) -> io::Result<Self> {
        metrics.slots(slots.count);
        // Exists before its threads, so that a failure below ends those that run.
        let started = Self {
            queue: Arc::new(JobQueue::new(slots, metrics)),
            sessions: AtomicU64::new(0),
        };
        for _ in 0..slots.count {
            JobQueue::add_seat(&started.queue, &mut started.queue.lock())?;
        }
        Ok(started)
    }

    /// A number under which a session has its share.
    pub(crate) fn new_session(&self) -> u64 {
        self.sessions.fetch_add(1, Ordering::Relaxed)
    }

    /// Jobs of `client` that wait for a slot, however it comes.
    pub(crate) fn waiting(&self, client: ClientIdentity) -> usize {
        self.queue.lock().jobs.waiting(&[Share::Client(client)])
    }

    /// What there is to do just now.
    pub(crate) fn load(&self) -> Load {
        self.queue.load()
    }

    /// Runs `work` of `flow` on a slot; `done` gets its value or its panic, on
    /// the slot's thread.
    pub(crate) fn submit<T: Send + 'static>(
        &self,
        flow: Flow,
        length: Length,
        work: impl FnOnce(&Slot) -> T + Send + 'static,
        done: impl FnOnce(Result<T, Panicked>) + Send + 'static,
    ) {
        let job = Box::new(move |slot: &Slot| {
            let outcome = catch_unwind(AssertUnwindSafe(|| work(slot)));
            done(outcome.map_err(|payload| Panicked(said(payload.as_ref()))));
        });
        self.queue.push(flow, length, job);
    }

    /// Waits until every job has run; blocks. Jobs that come later never run.
    pub(crate) fn close(&self) {
        self.queue.stop();
        while let Some(thread) = self.next_thread() {
            if thread.join().is_err() {
                tracing::error!("a solver slot ended by a panic outside its job");
            }
        }
    }

    fn next_thread(&self) -> Option<JoinHandle<()>> {
        self.queue.lock().threads.pop()
    }
}

impl Drop for SolverThreads {
    fn drop(&mut self) {
        self.queue.stop();
    }
}

/// What a panic said.
pub(crate) fn said(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(ToString::to_string);
    text.or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "panic without a message".to_owned())
}

#[cfg(test)]
mod tests;
