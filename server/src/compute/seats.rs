//! Seats: threads with a rayon pool each, on which jobs run. There are as many as
//! slots, and more while jobs that paused sit on theirs.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};

use super::Slot;
use super::queue::{Backlog, JobQueue};

/// Jobs that may pause at one time.
const MOST_PAUSED: usize = 32;

impl JobQueue {
    /// Whether there is a seat for another job while one pauses.
    pub(super) fn has_seat(this: &Arc<Self>, state: &mut Backlog) -> bool {
        let is_full = state.seats >= this.slots.count + MOST_PAUSED;
        state.idle > 0 || (!is_full && Self::add_seat(this, state).is_ok())
    }

    /// Starts a further seat.
    ///
    /// # Errors
    /// When the system gives no more threads.
    pub(super) fn add_seat(this: &Arc<Self>, state: &mut Backlog) -> io::Result<()> {
        let seat = state.seats;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(this.slots.threads)
            .thread_name(move |thread| format!("solver-{seat}-{thread}"))
            .build()
            .map_err(io::Error::other)?;
        let queue = Arc::clone(this);
        let builder = std::thread::Builder::new().name(format!("seat-{seat}"));
        let thread = builder.spawn(move || serve(&queue, &pool))?;
        state.threads.push(thread);
        state.seats += 1;
        Ok(())
    }
}

fn serve(queue: &Arc<JobQueue>, pool: &rayon::ThreadPool) {
    let mut last = None;
    while let Some(begun) = queue.next(last.take()) {
        let (flow, job) = (begun.flow, begun.job);
        let slot = Slot {
            queue: Arc::clone(queue),
            flow,
            turn: Mutex::new(begun.turn),
        };
        // The job catches the panics of its work; this one would be ours.
        let run = || pool.install(|| job(&slot));
        if catch_unwind(AssertUnwindSafe(run)).is_err() {
            tracing::error!("a job's report panicked");
        }
        slot.show_residual(0.0);
        queue.job_ended();
        let turn = slot
            .turn
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        last = Some((flow, turn));
    }
}
