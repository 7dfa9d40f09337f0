//! How many lines of the log refusals may write: a bucket that fills at a rate and holds a burst.
//! What finds it empty is counted instead, and told in one line now and then.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Whose refusals a line is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Whose {
    /// Those of callers who have proved no name where one is asked for, failed handshakes
    /// included.
    Strangers,
    /// Those of all others.
    Clients,
}

impl Whose {
    pub(crate) const ALL: [Self; 2] = [Self::Strangers, Self::Clients];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Strangers => "strangers",
            Self::Clients => "clients",
        }
    }

    /// Lines in a second, over a while. A refusal of a stranger takes up to two, some 700 bytes.
    fn rate(self) -> f64 {
        match self {
            Self::Strangers => 4.0,
            Self::Clients => 20.0,
        }
    }
}

/// Seconds of the rate that may come at once.
const BURST: f64 = 10.0;

struct State {
    left: f64,
    at: Instant,
    left_out: u64,
}

/// The lines of one kind.
pub(crate) struct LineBudget {
    rate: f64,
    state: Mutex<State>,
}

impl LineBudget {
    pub(crate) fn new(whose: Whose) -> Self {
        let rate = whose.rate();
        let state = State {
            left: BURST * rate,
            at: Instant::now(),
            left_out: 0,
        };
        Self {
            rate,
            state: Mutex::new(state),
        }
    }

    /// Whether one more may be written at `now`; counted as left out if not.
    pub(crate) fn take(&self, now: Instant) -> bool {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let since = now.saturating_duration_since(state.at).as_secs_f64();
        state.left = (state.left + self.rate * since).min(BURST * self.rate);
        state.at = now;
        let may = state.left >= 1.0;
        if may {
            state.left -= 1.0;
        } else {
            state.left_out += 1;
        }
        may
    }

    /// How many were left out since the last call.
    pub(crate) fn left_out(&self) -> u64 {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut state.left_out)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_flood_writes_its_burst_then_its_rate_and_the_rest_is_counted() {
        let (budget, start) = (LineBudget::new(Whose::Strangers), Instant::now());
        let written = |seconds: u64| {
            let now = start + Duration::from_secs(seconds);
            (0..1000).filter(|_| budget.take(now)).count()
        };
        assert_eq!(written(0), 40);
        assert_eq!(budget.left_out(), 960);
        assert_eq!(written(1), 4);
        assert_eq!(written(1000), 40);
        assert_eq!(budget.left_out(), 996 + 960);
        assert_eq!(budget.left_out(), 0);
    }
}
