//! Growing pauses between attempts to connect again.

use std::time::{Duration, Instant};

const FIRST_PAUSE: Duration = Duration::from_millis(50);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);
const SHORTEST_ATTEMPT: Duration = Duration::from_secs(1);

/// Pauses of 50 ms, doubling to 2 s, until the patience is used up.
#[derive(Clone, Debug)]
pub(super) struct Backoff {
    until: Option<Instant>,
    pause: Duration,
    attempts: u32,
}

impl Backoff {
    /// Starts at the break. No patience at all gives no attempt.
    pub(super) fn new(patience: Duration, now: Instant) -> Self {
        Self {
            // A patience that no clock can add is one without an end.
            until: now.checked_add(patience),
            pause: FIRST_PAUSE,
            attempts: 0,
        }
    }

    /// The pause before the next attempt; `None` when there is to be none.
    pub(super) fn pause(&mut self, now: Instant) -> Option<Duration> {
        let left = self.left(now);
        if left.is_zero() {
            return None;
        }
        let pause = self.pause.min(left);
        self.pause = (self.pause * 2).min(LONGEST_PAUSE);
        self.attempts += 1;
        Some(pause)
    }

    /// Time for an attempt: what is left, but enough to answer.
    pub(super) fn attempt(&self, now: Instant) -> Duration {
        self.left(now).max(SHORTEST_ATTEMPT)
    }

    fn left(&self, now: Instant) -> Duration {
        self.until
            .map_or(Duration::MAX, |until| until.saturating_duration_since(now))
    }

    /// Attempts so far.
    pub(super) fn attempts(&self) -> u32 {
        self.attempts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_double_up_to_two_seconds_until_the_patience_ends() {
        let start = Instant::now();
        let mut backoff = Backoff::new(Duration::from_secs(9), start);
        let (mut now, mut pauses) = (start, Vec::new());
        while let Some(pause) = backoff.pause(now) {
            now += pause;
            pauses.push(pause.as_millis());
        }
        assert_eq!(
            pauses,
            [50, 100, 200, 400, 800, 1600, 2000, 2000, 1850],
            "the last one ends with the patience"
        );
        assert_eq!(backoff.attempts(), 9);
        assert_eq!(backoff.attempt(now), SHORTEST_ATTEMPT);
        assert_eq!(backoff.attempt(start), Duration::from_secs(9));
    }

    #[test]
    fn no_patience_means_no_attempt_and_the_longest_has_no_end() {
        let now = Instant::now();
        assert_eq!(Backoff::new(Duration::ZERO, now).pause(now), None);
        let mut endless = Backoff::new(Duration::MAX, now);
        assert!(endless.pause(now + Duration::from_secs(1 << 30)).is_some());
    }
}
