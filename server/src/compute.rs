//! The solver threads: a fixed number, each with its own rayon pool, fed by one
//! queue that is fair between clients.
//!
//! A job is the building of prepared data or one increment of one session, so
//! sessions take turns. A slot that has ended a job waits a moment for the same
//! client's next one before it serves a client that has more running: the result
//! has to reach its reader before the next increment may start. A panic in a job
//! is caught at the slot and reported; the process lives. No job waits for a
//! socket.

use std::any::Any;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ::metrics::Gauge;

use crate::client_key::ClientKey;
use crate::fair_queue::FairQueue;
use crate::metrics::Metrics;

/// How long a slot waits for the next job of the client that it has served.
const LINGER: Duration = Duration::from_millis(5);

type Job = Box<dyn FnOnce(&Slot) + Send>;

/// One solver thread, as its jobs see it.
pub(crate) struct Slot {
    residual: Gauge,
}

impl Slot {
    /// Shows how far the running step is from its equilibrium.
    pub(crate) fn show_residual(&self, residual: f64) {
        self.residual.set(residual);
    }
}

struct Waiting {
    job: Job,
    since: Instant,
}

/// Jobs that no slot has taken yet.
#[derive(Default)]
struct Backlog {
    jobs: FairQueue<ClientKey, Waiting>,
    closed: bool,
}

/// Between those who submit jobs and the slots that take them.
struct JobQueue {
    backlog: Mutex<Backlog>,
    arrived: Condvar,
    metrics: Arc<Metrics>,
}

impl JobQueue {
    fn lock(&self) -> MutexGuard<'_, Backlog> {
        // Jobs run outside the lock, so a poisoned state is whole.
        self.backlog.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next job for a slot that has just served `last`.
    fn next(&self, last: Option<ClientKey>) -> Option<(ClientKey, Waiting)> {
        let mut state = self.linger(self.lock(), last);
        loop {
            if let Some(found) = state.jobs.pop() {
                self.metrics.queue_depth(state.jobs.len());
                return Some(found);
            }
            if state.closed {
                return None;
            }
            state = self
                .arrived
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Waits a moment for a job of `last`, if that one would be next.
    fn linger<'a>(
        &self,
        state: MutexGuard<'a, Backlog>,
        last: Option<ClientKey>,
    ) -> MutexGuard<'a, Backlog> {
        let awaited = |state: &mut Backlog| {
            !state.closed && last.is_some_and(|client| state.jobs.would_be_next(client))
        };
        let waited = self.arrived.wait_timeout_while(state, LINGER, awaited);
        waited.unwrap_or_else(PoisonError::into_inner).0
    }

    fn finished(&self, client: ClientKey, seconds: f64) {
        self.lock().jobs.finished(client, seconds);
    }
}

/// A job panicked; holds what it said.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Panicked(pub(crate) String);

/// The solver threads.
pub(crate) struct SolverThreads {
    queue: Arc<JobQueue>,
    threads: Mutex<Vec<JoinHandle<()>>>,
}

impl SolverThreads {
    /// Starts `slots` solver threads with a pool of `threads` each.
    ///
    /// # Errors
    /// When the system gives no more threads.
    pub(crate) fn start(slots: usize, threads: usize, metrics: &Arc<Metrics>) -> io::Result<Self> {
        metrics.slots(slots);
        let queue = Arc::new(JobQueue {
            backlog: Mutex::default(),
            arrived: Condvar::new(),
            metrics: Arc::clone(metrics),
        });
        // Exists before its threads, so that a failure below ends those that run.
        let started = Self {
            queue: Arc::clone(&queue),
            threads: Mutex::default(),
        };
        for slot in 0..slots {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .thread_name(move |thread| format!("solver-{slot}-{thread}"))
                .build()
                .map_err(io::Error::other)?;
            let queue = Arc::clone(&queue);
            let residual = metrics.residual(slot);
            let run = move || serve_slot(&queue, &pool, &Slot { residual });
            let builder = std::thread::Builder::new().name(format!("slot-{slot}"));
            started.lock_threads().push(builder.spawn(run)?);
        }
        Ok(started)
    }

    /// Jobs of `client` that wait for a slot.
    pub(crate) fn waiting(&self, client: ClientKey) -> usize {
        self.queue.lock().jobs.waiting(client)
    }

    /// Runs `work` of `client` on a slot; `done` gets its value or its panic, on
    /// the slot's thread.
    pub(crate) fn submit<T: Send + 'static>(
        &self,
        client: ClientKey,
        work: impl FnOnce(&Slot) -> T + Send + 'static,
        done: impl FnOnce(Result<T, Panicked>) + Send + 'static,
    ) {
        let job = Box::new(move |slot: &Slot| {
            let outcome = catch_unwind(AssertUnwindSafe(|| work(slot)));
            done(outcome.map_err(|payload| Panicked(said(payload.as_ref()))));
        });
        let mut state = self.queue.lock();
        let since = Instant::now();
        state.jobs.push(client, Waiting { job, since });
        self.queue.metrics.queue_depth(state.jobs.len());
        drop(state);
        // A slot that lingers for another client must not swallow the only call.
        self.queue.arrived.notify_all();
    }

    /// Waits until every job has run; blocks. Jobs that come later never run.
    pub(crate) fn close(&self) {
        self.stop();
        let threads = std::mem::take(&mut *self.lock_threads());
        for thread in threads {
            if thread.join().is_err() {
                tracing::error!("a solver slot ended by a panic outside its job");
            }
        }
    }

    fn stop(&self) {
        self.queue.lock().closed = true;
        self.queue.arrived.notify_all();
    }

    fn lock_threads(&self) -> MutexGuard<'_, Vec<JoinHandle<()>>> {
        self.threads.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for SolverThreads {
    fn drop(&mut self) {
        self.stop();
    }
}

fn serve_slot(queue: &JobQueue, pool: &rayon::ThreadPool, slot: &Slot) {
    let mut last = None;
    while let Some((client, waiting)) = queue.next(last) {
        let start = Instant::now();
        queue.metrics.job_started(waiting.since.elapsed());
        // The job catches the panics of its work; this one would be ours.
        let run = || pool.install(|| (waiting.job)(slot));
        if catch_unwind(AssertUnwindSafe(run)).is_err() {
            tracing::error!("a job's report panicked");
        }
        slot.show_residual(0.0);
        queue.metrics.job_ended();
        queue.finished(client, start.elapsed().as_secs_f64());
        last = Some(client);
    }
}

/// What a panic said.
pub(crate) fn said(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(ToString::to_string);
    text.or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "panic without a message".to_owned())
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    #[test]
    fn a_panic_is_reported_and_the_slot_goes_on() {
        let solvers = SolverThreads::start(1, 1, &Metrics::new().unwrap()).unwrap();
        let (sender, receiver) = mpsc::channel();
        let other = sender.clone();
        solvers.submit(
            ClientKey::Unknown,
            |_| -> u32 { panic!("broken") },
            move |outcome| other.send(outcome).unwrap(),
        );
        solvers.submit(
            ClientKey::Unknown,
            |_| 7,
            move |outcome| sender.send(outcome).unwrap(),
        );
        assert_eq!(receiver.recv().unwrap(), Err(Panicked("broken".into())));
        assert_eq!(receiver.recv().unwrap(), Ok(7));
        solvers.close();
    }

    #[test]
    fn jobs_run_in_the_pool_of_their_slot() {
        let solvers = SolverThreads::start(1, 3, &Metrics::new().unwrap()).unwrap();
        let (sender, receiver) = mpsc::channel();
        solvers.submit(
            ClientKey::Unknown,
            |_| rayon::current_num_threads(),
            move |outcome| sender.send(outcome).unwrap(),
        );
        assert_eq!(receiver.recv().unwrap(), Ok(3));
        solvers.close();
    }
}
