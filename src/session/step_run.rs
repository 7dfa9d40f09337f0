//! A step under way: which increments are done, and where the next one leads.
//!
//! It holds the two drives that the step leads from and to, and the seconds that its
//! increments have taken: a wall limit is that of the step, and pauses between two
//! increments do not count.

use crate::model::counters::Counters;
use crate::model::drive::Drive;
use crate::model::ending::Ending;
use crate::report::Termination;

/// Where the prepared data came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reuse {
    /// Built for this session: its seconds count in the first step.
    Built,
    /// The prepared data were taken from a cache.
    Reused,
}

/// A step under way.
#[derive(Clone, Debug)]
pub struct StepRun {
    /// Loads, poses and supports at which the step begins.
    start: Drive,
    /// Loads, poses and supports at which the step ends.
    end: Drive,
    /// Number of increments of the step.
    increments: u32,
    /// Number of increments that are over.
    done: u32,
    /// Whether the step is over, by its last increment or by one that failed.
    finished: bool,
    /// Wall seconds that its increments have taken, which `max_wall_time` limits.
    seconds: f64,
}

impl StepRun {
    /// A step from `start` to `end` in equal increments.
    pub(crate) fn new(start: Drive, end: Drive, increments: u32) -> Self {
        Self {
            start,
            end,
            increments,
            done: 0,
            finished: false,
            seconds: 0.0,
        }
    }

    /// The same step where `done` of its increments are done.
    pub(crate) fn after(self, done: u32) -> Self {
        Self { done, ..self }
    }

    /// Number and drive of the next increment; none when the step is finished.
    pub(crate) fn upcoming(&self) -> Option<(u32, Drive)> {
        if self.finished || self.done >= self.increments {
            return None;
        }
        let increment = self.done + 1;
        let fraction = f64::from(increment) / f64::from(self.increments);
        Some((increment, self.start.towards(&self.end, fraction)))
    }

    /// Wall seconds left of the step's limit `most`.
    pub(crate) fn seconds_left(&self, most: Option<f64>) -> Option<f64> {
        most.map(|most| most - self.seconds)
    }

    /// Notes how an increment ended, and what it took.
    pub(crate) fn finish(&mut self, increment: u32, ending: &Ending, counters: &Counters) {
        self.done = increment;
        self.finished = ending.termination != Termination::Converged || ending.leak.is_some();
        self.seconds += counters.start.elapsed().as_secs_f64();
    }

    /// The increment, and the fraction of the step where `part` of it is done.
    pub(crate) fn time(&self, increment: u32, part: f64) -> (u32, f64) {
        let [before, after] =
            [increment - 1, increment].map(|done| f64::from(done) / f64::from(self.increments));
        (increment, before + part * (after - before))
    }

    /// Increments finished so far.
    pub fn done(&self) -> u32 {
        self.done
    }

    /// Increments in all.
    pub fn increments(&self) -> u32 {
        self.increments
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;

    #[test]
    fn increments_share_the_wall_time_of_their_step() {
        let rest = Drive {
            load: 0.0,
            poses: Vec::new(),
            pushes: Vec::new(),
            support_pushes: Vec::new(),
            friction: Vec::new(),
            supports: Vec::new(),
            motions: Vec::new(),
            given: Default::default(),
            fluids: Vec::new(),
        };
        let converged = Ending::converged();
        let mut step = StepRun::new(rest.clone(), rest, 3);
        for increment in 1..=2 {
            let mut counters = Counters::new();
            counters.start = Instant::now()
                .checked_sub(Duration::from_secs(4))
                .expect("a clock that has run for a while");
            step.finish(increment, &converged, &counters);
        }
        let left = step.seconds_left(Some(10.0)).expect("a limit");
        assert!((1.0..=2.0).contains(&left), "{left}");
        assert_eq!(step.seconds_left(None), None);
    }
}
