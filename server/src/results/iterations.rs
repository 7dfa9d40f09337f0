//! Iteration statistics on their way from a solver thread to all readers of a
//! session: the newest wins, and each reader counts what it skipped.
//!
//! The solver thread stores one record whatever the number of readers; a slow
//! reader costs it nothing.

use std::sync::Arc;
use std::time::Duration;

use signorini_proto::v1 as wire;
use tokio::sync::watch;
use tokio::time::Instant;

/// The newest iteration of a session.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Newest {
    /// Iterations published so far; 0 before the first.
    pub(crate) number: u64,
    /// Results that were finished when it was made.
    pub(crate) after_event: i64,
    pub(crate) sequence: i64,
    pub(crate) report: wire::IterationReport,
}

/// Where a solver thread publishes.
#[derive(Clone, Debug)]
pub(crate) struct Iterations(Arc<watch::Sender<Newest>>);

impl Default for Iterations {
    fn default() -> Self {
        Self(Arc::new(watch::Sender::new(Newest::default())))
    }
}

impl Iterations {
    /// Replaces the newest iteration.
    pub(crate) fn publish(&self, sequence: i64, after_event: i64, report: wire::IterationReport) {
        self.0.send_modify(|newest| {
            newest.number += 1;
            newest.sequence = sequence;
            newest.after_event = after_event;
            newest.report = report;
        });
    }

    /// The newest iteration.
    pub(crate) fn newest(&self) -> Newest {
        self.0.borrow().clone()
    }

    /// A reader of what is published from now on, at most one in `interval`.
    pub(crate) fn reader(&self, interval: Duration) -> IterationReader {
        let receiver = self.0.subscribe();
        let seen = receiver.borrow().number;
        IterationReader {
            receiver,
            seen,
            interval,
            due: Instant::now(),
        }
    }
}

/// What one stream has seen of the iterations.
#[derive(Debug)]
pub(crate) struct IterationReader {
    receiver: watch::Receiver<Newest>,
    seen: u64,
    interval: Duration,
    due: Instant,
}

impl IterationReader {
    /// The newest iteration, unless it is too early for another one or it
    /// belongs before a result that the stream has sent already.
    pub(crate) fn take(&mut self, last_event: i64) -> Option<wire::IterationStatistics> {
        if Instant::now() < self.due {
            return None;
        }
        let newest = self.receiver.borrow_and_update().clone();
        if newest.after_event < last_event {
            None
        } else {
            self.pass(newest)
        }
    }

    /// `newest` with the number of those skipped, if the stream has not seen it and it is not
    /// too early for another one.
    pub(crate) fn pass(&mut self, newest: Newest) -> Option<wire::IterationStatistics> {
        if Instant::now() < self.due {
            return None;
        }
        let skipped = newest.number.checked_sub(self.seen + 1)?;
        self.seen = newest.number;
        self.due = Instant::now() + self.interval;
        Some(wire::IterationStatistics {
            sequence: newest.sequence,
            report: Some(newest.report),
            skipped_count: i64::try_from(skipped).unwrap_or(i64::MAX),
        })
    }

    /// Returns when there may be something to take.
    pub(crate) async fn changed(&mut self) {
        tokio::time::sleep_until(self.due).await;
        if self.receiver.changed().await.is_err() {
            // The session is gone; its outbox says so.
            std::future::pending::<()>().await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(krylov_iterations: i32) -> wire::IterationReport {
        wire::IterationReport {
            krylov_iterations,
            ..Default::default()
        }
    }

    #[test]
    fn newest_iteration_wins_and_the_others_are_counted() {
        let iterations = Iterations::default();
        let mut reader = iterations.reader(Duration::ZERO);
        for number in 1..=5 {
            iterations.publish(3, 0, report(number));
        }
        let taken = reader.take(0).unwrap();
        assert_eq!((taken.skipped_count, taken.sequence), (4, 3));
        assert_eq!(taken.report.unwrap().krylov_iterations, 5);
        assert_eq!(reader.take(0), None);
    }

    #[test]
    fn an_iteration_older_than_a_sent_result_is_stale_and_counts_as_skipped() {
        let iterations = Iterations::default();
        let mut reader = iterations.reader(Duration::ZERO);
        iterations.publish(1, 0, report(1));
        assert_eq!(reader.take(1), None);
        iterations.publish(2, 1, report(1));
        assert_eq!(reader.take(1).unwrap().skipped_count, 1);
    }

    #[test]
    fn iterations_keep_their_distance() {
        let iterations = Iterations::default();
        let mut reader = iterations.reader(Duration::from_secs(3600));
        iterations.publish(1, 0, report(1));
        assert!(reader.take(0).is_some());
        iterations.publish(1, 0, report(2));
        assert_eq!(reader.take(0), None);
        // Nor does the last one before a result come too early.
        assert_eq!(reader.pass(iterations.newest()), None);
    }
}
