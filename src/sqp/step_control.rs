//! Parts of the way to a goal, and the states to go back to between them.
//!
//! ```text
//! success:  reached += part,  part *= 1.5
//! failure:  part /= 2, back to the last good state
//! ```
//!
//! Fractions are of the way from the state at the start to the goal, in [0, 1]; the last
//! part ends at the goal exactly.

use super::lowest_mode::LowestMode;
use super::run::Run;
use crate::model::state::State;

/// Growth of the part after success.
const GROWTH: f64 = 1.5;

/// A state to go back to, with the softest motion of its equilibrium.
pub(crate) struct KeptState {
    /// The state to go back to.
    pub(crate) state: State,
    /// Softest motion of its equilibrium, which belongs to the state and not to what
    /// was tried since.
    lowest_mode: Option<LowestMode>,
}

impl KeptState {
    /// The present one.
    pub(crate) fn of(run: &Run<'_>) -> Self {
        Self {
            state: run.state.clone(),
            lowest_mode: run.learned.lowest_mode.clone(),
        }
    }

    /// Goes back to it.
    pub(crate) fn restore(&self, run: &mut Run<'_>) {
        run.state.clone_from(&self.state);
        run.learned.lowest_mode.clone_from(&self.lowest_mode);
    }
}

/// Parts of the way.
pub(crate) struct Parts {
    /// Fraction of the way that is solved, in [0, 1].
    pub(crate) reached: f64,
    /// Fraction of the way that the next part takes.
    pub(crate) part: f64,
    /// Longest part that may be taken from there.
    pub(crate) longest: f64,
    /// Number of failures one after the other; a success sets it to zero.
    pub(crate) failures: u32,
    /// Largest penalty that led nowhere, so that it is not tried again.
    pub(crate) tried: f64,
}

impl Parts {
    /// The way before its first part, which takes the fraction `longest`.
    pub(crate) fn new(longest: f64) -> Self {
        Self {
            reached: 0.0,
            part: longest,
            longest,
            failures: 0,
            tried: 0.0,
        }
    }

    /// End of the next part.
    pub(crate) fn next(&self) -> f64 {
        self.after(self.part)
    }

    /// Where a part that takes the fraction `part` ends.
    pub(crate) fn after(&self, part: f64) -> f64 {
        let next = self.reached + part;
        if next >= 1.0 - 1e-12 { 1.0 } else { next }
    }

    /// Takes `next` as reached by a fall; the next part is as long as that was.
    pub(crate) fn land(&mut self, next: f64) {
        self.part = next - self.reached;
        self.reached = next;
        self.failures = 0;
    }

    /// Takes the part just solved as reached and makes the next one longer.
    pub(crate) fn succeed(&mut self) {
        self.reached = self.next();
        self.part *= GROWTH;
        self.failures = 0;
    }

    /// Lets no part from here take more than `longest`.
    pub(crate) fn bound(&mut self, longest: f64) {
        self.longest = longest;
        self.part = self.part.min(longest);
    }

    /// Halves what the next part takes, behind a failure.
    pub(crate) fn cut_back(&mut self) {
        self.part = 0.5 * (self.next() - self.reached);
    }
}
