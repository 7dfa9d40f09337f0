//! The log of a run with what people see of it.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::log::RowLog;
use super::row::Row;
use super::tally::Tally;
use crate::terminal::exit::Failure;
use crate::terminal::progress::{CaseProgress, Verbosity};

/// Between two lines of progress where no terminal shows a bar.
const NOTE_INTERVAL: Duration = Duration::from_secs(10);

/// Rows that are kept, counted and shown.
pub(crate) struct Ledger {
    log: RowLog,
    tally: Tally,
    progress: CaseProgress,
    noted: Instant,
}

/// A ledger that tasks share; none holds it while it waits for anything but the disk.
#[derive(Clone)]
pub(crate) struct Shared(Arc<Mutex<Ledger>>);

impl Shared {
    /// The ledger, for as long as the guard lives.
    pub(crate) fn lock(&self) -> MutexGuard<'_, Ledger> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Shares a ledger.
pub(crate) fn shared(ledger: Ledger) -> Shared {
    Shared(Arc::new(Mutex::new(ledger)))
}

impl Ledger {
    /// Goes on with a log whose rows are counted.
    pub(crate) fn new(log: RowLog, tally: Tally, cases: u64, verbosity: Verbosity) -> Self {
        let progress = CaseProgress::new(cases, verbosity);
        progress.set(log.done(), tally.failures());
        Self {
            log,
            tally,
            progress,
            noted: Instant::now(),
        }
    }

    /// Its log.
    pub(crate) fn log(&mut self) -> &mut RowLog {
        &mut self.log
    }

    /// How the cases have ended.
    pub(crate) fn tally(&self) -> &Tally {
        &self.tally
    }

    /// The line that people see.
    pub(crate) fn progress(&self) -> &CaseProgress {
        &self.progress
    }

    /// Keeps a row, unless the case has one.
    pub(crate) fn add(&mut self, row: &Row) -> Result<(), Failure> {
        if self.log.add(row)? {
            self.tally.add(row);
            self.progress.set(self.log.done(), self.tally.failures());
            if self.noted.elapsed() >= NOTE_INTERVAL {
                self.noted = Instant::now();
                self.progress.log();
            }
        }
        Ok(())
    }
}
