//! A lease, as its holder knows it.
//!
//! The holder falls silent two thirds of the time to live after the beginning of the last renewal
//! that it knows of, by its own monotonic clock, which goes on while the process is stopped. The
//! entry itself lives from when the other side had it, which is later.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Of one session.
pub(crate) struct Lease {
    /// Its revision when it was taken: greater than that of every holder before.
    pub(super) epoch: u64,
    ttl: Duration,
    start: Instant,
    /// Of the newest renewal that worked, nanoseconds after the start.
    renewed: AtomicU64,
    /// Of the entry, for the next renewal.
    revision: AtomicU64,
    lost: AtomicBool,
    /// The newest record of the session in the stream.
    pub(super) tail: AtomicU64,
    /// Records of this holder so far.
    pub(super) records: AtomicU64,
    /// Bytes of records after the newest that holds everything.
    pub(super) bytes: AtomicU64,
    /// Bytes of the newest that holds everything.
    pub(super) whole: AtomicU64,
}

impl Lease {
    /// Taken at that revision by a call that began at `asked`.
    pub(super) fn new(revision: u64, ttl: Duration, asked: Instant) -> Self {
        Self {
            epoch: revision,
            ttl,
            start: asked,
            renewed: AtomicU64::new(0),
            revision: AtomicU64::new(revision),
            lost: AtomicBool::new(false),
            tail: AtomicU64::new(0),
            records: AtomicU64::new(0),
            bytes: AtomicU64::new(0),
            whole: AtomicU64::new(0),
        }
    }

    /// Whether the session is this server's: what is not so once is never so again.
    pub(crate) fn holds(&self) -> bool {
        self.holds_at(Instant::now())
    }

    fn holds_at(&self, now: Instant) -> bool {
        if self.lost.load(Ordering::Acquire) {
            return false;
        }
        let holds = self.age_at(now) < self.ttl * 2 / 3;
        if !holds {
            self.lose();
        }
        holds
    }

    /// Another has it, or it cannot be known.
    pub(super) fn lose(&self) {
        self.lost.store(true, Ordering::Release);
    }

    fn age_at(&self, now: Instant) -> Duration {
        let renewed = Duration::from_nanos(self.renewed.load(Ordering::Acquire));
        now.saturating_duration_since(self.start + renewed)
    }

    /// Time since the last renewal.
    pub(super) fn age(&self) -> Duration {
        self.age_at(Instant::now())
    }

    pub(super) fn is_due(&self) -> bool {
        self.age() >= self.ttl / 3
    }

    pub(super) fn revision(&self) -> u64 {
        self.revision.load(Ordering::Acquire)
    }

    /// The entry has that revision now.
    pub(super) fn follow(&self, revision: u64) {
        self.revision.store(revision, Ordering::Release);
    }

    /// A renewal worked that began at `asked`.
    pub(super) fn renewed(&self, revision: u64, asked: Instant) {
        self.follow(revision);
        let since = asked.saturating_duration_since(self.start).as_nanos();
        let since = u64::try_from(since).unwrap_or(u64::MAX);
        self.renewed.fetch_max(since, Ordering::AcqRel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TTL: Duration = Duration::from_secs(6);

    fn second(lease: &Lease, seconds: u64) -> Instant {
        lease.start + Duration::from_secs(seconds)
    }

    #[test]
    fn its_holder_is_silent_from_two_thirds_on_and_for_good() {
        let lease = Lease::new(7, TTL, Instant::now());
        assert!(lease.holds_at(second(&lease, 3)));
        lease.renewed(8, second(&lease, 2));
        assert!(lease.holds_at(second(&lease, 5)));
        assert!(!lease.holds_at(second(&lease, 6)));
        // A renewal that comes late does not bring it back.
        lease.renewed(9, second(&lease, 6));
        assert!(!lease.holds_at(second(&lease, 6)));
        assert_eq!((lease.epoch, lease.revision()), (7, 9));
    }

    #[test]
    fn a_renewal_counts_from_its_beginning_and_none_makes_it_older() {
        let lease = Lease::new(1, TTL, Instant::now());
        lease.renewed(2, second(&lease, 3));
        lease.renewed(3, second(&lease, 1));
        assert!(lease.holds_at(second(&lease, 6)));
        lease.lose();
        assert!(!lease.holds_at(second(&lease, 3)));
    }
}
