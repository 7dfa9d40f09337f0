//! How many calls a client may make: a bucket each, which fills at the rate that is allowed and
//! holds two seconds of it.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use crate::door::client_key::ClientIdentity;
use crate::fault::Fault;

/// Seconds of the rate that may come at once.
const BURST: f64 = 2.0;
/// Clients beyond which those who have called nothing of late are forgotten.
const MANY: usize = 4096;

struct Bucket {
    left: f64,
    at: Instant,
}

/// The buckets of all clients.
pub(crate) struct CallRates {
    limit: u32,
    buckets: Mutex<HashMap<ClientIdentity, Bucket>>,
}

impl CallRates {
    /// At most `limit` calls in a second; 0: as many as there are.
    pub(crate) fn new(limit: u32) -> Self {
        Self {
            limit,
            buckets: Mutex::default(),
        }
    }

    /// Counts a call.
    ///
    /// # Errors
    /// `CallRate` for one too many.
    pub(super) fn count(&self, client: ClientIdentity, now: Instant) -> Result<(), Fault> {
        if self.limit == 0 {
            return Ok(());
        }
        let (rate, limit) = (f64::from(self.limit), self.limit);
        let filled = |bucket: &Bucket| {
            let since = now.saturating_duration_since(bucket.at).as_secs_f64();
            (bucket.left + rate * since).min(BURST * rate)
        };
        let mut buckets = self.buckets.lock().unwrap_or_else(PoisonError::into_inner);
        if buckets.len() > MANY {
            buckets.retain(|_, bucket| filled(bucket) < BURST * rate);
        }
        let full = || Bucket {
            left: BURST * rate,
            at: now,
        };
        let bucket = buckets.entry(client).or_insert_with(full);
        bucket.left = filled(bucket);
        bucket.at = now;
        if bucket.left < 1.0 {
            return Err(Fault::CallRate { limit });
        }
        bucket.left -= 1.0;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_client_has_its_rate_and_a_burst_of_two_seconds() {
        let (rates, start) = (CallRates::new(5), Instant::now());
        let [one, other] = [1, 2].map(ClientIdentity::User);
        let calls = |client, seconds: u64| {
            let now = start + Duration::from_secs(seconds);
            (0..100)
                .take_while(|_| rates.count(client, now).is_ok())
                .count()
        };
        assert_eq!(calls(one, 0), 10);
        assert_eq!(rates.count(one, start), Err(Fault::CallRate { limit: 5 }));
        assert_eq!(calls(other, 0), 10);
        assert_eq!(calls(one, 1), 5);
        assert_eq!(calls(one, 100), 10);
    }

    #[test]
    fn no_limit_counts_nothing_and_the_idle_are_forgotten() {
        let start = Instant::now();
        let free = CallRates::new(0);
        assert!((0..100).all(|_| free.count(ClientIdentity::Unknown, start).is_ok()));
        let rates = CallRates::new(1);
        for user in 0..2 * MANY as u32 {
            let now = start + Duration::from_secs(u64::from(user));
            rates.count(ClientIdentity::User(user), now).unwrap();
        }
        assert!(rates.buckets.lock().unwrap().len() <= MANY + 1);
    }
}
