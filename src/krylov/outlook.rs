//! Whether iterations are still on their way to a target: the decades that the last ones
//! brought against those that are missing.
//!
//! ```text
//! hopeless:  missing decades > SLACK (decades of the last window / window) iterations left
//! ```
//!
//! A rule on numbers of iterations, the same on every machine.

/// Iterations between two looks.
const WINDOW: u32 = 60;
/// How many times faster than lately the rest may turn out to go.
const SLACK: f64 = 3.0;

/// What the iterations of one system have brought.
#[derive(Clone, Copy, Debug)]
pub struct Outlook {
    /// Iterations at most.
    most: u32,
    /// Iterations so far.
    done: u32,
    /// Iterations of the present window.
    since: u32,
    /// Least residual over its target when the window began; none before the first.
    before: Option<f64>,
    /// Least residual over its target in the window.
    least: f64,
}

impl Outlook {
    /// Of a system that may take `most` iterations.
    pub fn new(most: u32) -> Self {
        Self {
            most,
            done: 0,
            since: 0,
            before: None,
            least: f64::INFINITY,
        }
    }

    /// Forgets how fast it went: the system has become another one.
    pub fn restart(&mut self) {
        (self.since, self.before, self.least) = (0, None, f64::INFINITY);
    }

    /// Notes an iteration that left `ratio`, the residual over its target; whether the
    /// target is out of reach.
    pub fn is_hopeless(&mut self, ratio: f64) -> bool {
        self.done += 1;
        self.since += 1;
        self.least = self.least.min(ratio);
        if self.since < WINDOW {
            return false;
        }
        let (least, left) = (self.least, self.most.saturating_sub(self.done));
        let before = self.before.replace(least);
        self.since = 0;
        let Some(before) = before else {
            return false;
        };
        let brought = (before / least).log10().max(0.0) / f64::from(WINDOW);
        least.log10() > SLACK * brought * f64::from(left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Iterations until there is no hope, of a residual that falls by `rate` each time.
    fn given_up(rate: f64) -> Option<u32> {
        let mut outlook = Outlook::new(600);
        let mut ratio = 1e8;
        (1..=600).find(|_| {
            ratio *= rate;
            outlook.is_hopeless(ratio)
        })
    }

    #[test]
    fn a_residual_that_stays_is_given_up_after_two_windows() {
        assert_eq!(given_up(1.0), Some(2 * WINDOW));
        assert_eq!(given_up(0.999), Some(2 * WINDOW));
    }

    #[test]
    fn what_arrives_in_time_is_let_run_and_what_does_not_is_not_given_up_at_once() {
        let taking = |iterations: f64| given_up(1e-8_f64.powf(1.0 / iterations));
        for iterations in [30.0, 300.0, 599.0] {
            assert_eq!(taking(iterations), None);
        }
        assert!(taking(1000.0) > Some(300) && taking(4000.0) > Some(WINDOW));
    }

    #[test]
    fn another_system_is_given_time_of_its_own() {
        let mut outlook = Outlook::new(600);
        for turn in 0..10 {
            outlook.restart();
            for _ in 0..WINDOW {
                assert!(!outlook.is_hopeless(1e8), "{turn}");
            }
        }
    }
}
