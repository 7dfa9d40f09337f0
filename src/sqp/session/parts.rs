//! Parts of the way to a goal, and the states to go back to between them.

use crate::sqp::stability::Softest;
use crate::sqp::state::{Snapshot, State};

/// Growth of the part after success.
const GROWTH: f64 = 1.5;

/// A state to go back to.
pub(super) struct Good {
    pub(super) fields: Snapshot,
    softest: Option<Softest>,
}

impl Good {
    pub(super) fn of(state: &State) -> Self {
        Self {
            fields: state.snapshot(),
            softest: state.softest.clone(),
        }
    }

    pub(super) fn restore(&self, state: &mut State) {
        state.restore(&self.fields);
        state.softest = self.softest.clone();
    }
}

/// Parts of the way.
pub(super) struct Parts {
    pub(super) reached: f64,
    pub(super) part: f64,
    /// One after the other.
    pub(super) failures: u32,
    /// Largest penalty that led nowhere.
    pub(super) tried: f64,
}

impl Parts {
    pub(super) fn new(part: f64) -> Self {
        Self {
            reached: 0.0,
            part,
            failures: 0,
            tried: 0.0,
        }
    }

    /// End of the next part.
    pub(super) fn next(&self) -> f64 {
        let next = self.reached + self.part;
        if next >= 1.0 - 1e-12 { 1.0 } else { next }
    }

    pub(super) fn succeed(&mut self) {
        self.reached = self.next();
        self.part *= GROWTH;
        self.failures = 0;
    }

    pub(super) fn cut_back(&mut self) {
        self.part = 0.5 * (self.next() - self.reached);
    }
}
