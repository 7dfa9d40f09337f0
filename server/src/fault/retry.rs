//! When a refused client should come back.
//!
//! The more was refused of late, the longer the wait; each wait is drawn anew between
//! half of it and one and a half, so that those refused together do not come together.
//! The memory of refusals belongs to the process: what is refused by one server of it
//! loads the others.

use std::hash::{BuildHasher, RandomState};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Wait after a single refusal, and the longest one, before it is drawn.
const SHORTEST: Duration = Duration::from_secs(1);
const LONGEST: Duration = Duration::from_secs(30);
/// Refusals that double the wait.
const DOUBLING: f64 = 16.0;
/// Time in which half of the refusals is forgotten, seconds.
const HALF_LIFE: f64 = 2.0;

/// Refusals of late.
struct Pressure {
    refusals: f64,
    at: Option<Instant>,
}

impl Pressure {
    /// Counts one more; the wait before it is drawn.
    fn refuse(&mut self, now: Instant) -> Duration {
        let since = self
            .at
            .map_or(Duration::ZERO, |at| now.saturating_duration_since(at));
        self.refusals *= (-since.as_secs_f64() / HALF_LIFE).exp2();
        let wait = SHORTEST.as_secs_f64() * (1.0 + self.refusals / DOUBLING);
        self.refusals += 1.0;
        self.at = Some(now);
        Duration::from_secs_f64(wait.min(LONGEST.as_secs_f64()))
    }
}

static PRESSURE: Mutex<Pressure> = Mutex::new(Pressure {
    refusals: 0.0,
    at: None,
});

/// The wait for a client that is refused now.
pub(crate) fn delay() -> Duration {
    let mut pressure = PRESSURE.lock().unwrap_or_else(PoisonError::into_inner);
    let wait = pressure.refuse(Instant::now());
    drop(pressure);
    wait.mul_f64(0.5 + random())
}

/// A number from 0 to 1; the keys of the standard hasher are random.
fn random() -> f64 {
    let bits = RandomState::new().hash_one(0_u8) >> 32;
    bits as f64 / f64::from(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waits_grow_with_refusals_up_to_a_limit_and_shrink_again() {
        let mut pressure = Pressure {
            refusals: 0.0,
            at: None,
        };
        let now = Instant::now();
        let waits: Vec<_> = (0..1000).map(|_| pressure.refuse(now)).collect();
        assert_eq!((waits[0], waits[999]), (SHORTEST, LONGEST));
        assert!(waits.is_sorted());
        let later = pressure.refuse(now + Duration::from_secs(60));
        assert!(later < SHORTEST.mul_f64(1.01), "{later:?}");
    }

    #[test]
    fn refused_clients_do_not_come_back_together() {
        let mut all: Vec<_> = (0..100).map(|_| random()).collect();
        assert!(all.iter().all(|one| (0.0..=1.0).contains(one)));
        all.sort_by(f64::total_cmp);
        all.dedup();
        assert!(all.len() > 90);
    }
}
