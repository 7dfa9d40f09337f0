//! The time that a step has a slot: what counts against the server's ceiling.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

#[derive(Default)]
struct Times {
    used: Duration,
    since: Option<Instant>,
}

/// Runs while the step does; stands while it waits for readers or a slot.
#[derive(Default)]
pub(super) struct SlotClock(Mutex<Times>);

/// The clock runs as long as this lives.
pub(super) struct Running<'a>(&'a SlotClock);

impl SlotClock {
    pub(super) fn run(&self) -> Running<'_> {
        self.lock().since = Some(Instant::now());
        Running(self)
    }

    /// Stands while `pause` lasts.
    pub(super) fn without<T>(&self, pause: impl FnOnce() -> T) -> T {
        self.stop();
        let value = pause();
        self.lock().since = Some(Instant::now());
        value
    }

    fn stop(&self) {
        let mut times = self.lock();
        if let Some(since) = times.since.take() {
            times.used += since.elapsed();
        }
    }

    /// Time that the step had a slot.
    pub(super) fn used(&self) -> Duration {
        let times = self.lock();
        times.used + times.since.map_or(Duration::ZERO, |since| since.elapsed())
    }

    fn lock(&self) -> MutexGuard<'_, Times> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        self.0.stop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_and_the_time_between_increments_do_not_count() {
        let clock = SlotClock::default();
        let (step, pause) = (Duration::from_millis(20), Duration::from_millis(60));
        {
            let _running = clock.run();
            std::thread::sleep(step);
            clock.without(|| std::thread::sleep(pause));
            let during = clock.without(|| [clock.used(), clock.used()]);
            assert_eq!(during[0], during[1]);
        }
        let used = clock.used();
        std::thread::sleep(step);
        assert!(used >= step, "{used:?}");
        assert_eq!(clock.used(), used);
        let _running = clock.run();
        std::thread::sleep(step);
        assert!(clock.used() >= used + step);
    }
}
