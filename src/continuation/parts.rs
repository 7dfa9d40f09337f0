//! Parts of a load path.
//!
//! ```text
//! success:  reached += part,  part *= 1.5
//! failure:  part /= 2, back to the last good state
//! ```
//!
//! Fractions are of the path from its start to its goal, in [0, 1]; the last
//! part ends at the goal exactly.

constants! {
    /// Growth of the part after success.
    const GROWTH: f64 = 1.5;
}

/// Parts of the path.
pub(crate) struct Parts {
    /// Fraction of the path that is solved, in [0, 1].
    pub(crate) reached: f64,
    /// Fraction of the path that the next part takes.
    pub(crate) part: f64,
    /// Longest part that may be taken from there.
    pub(crate) longest: f64,
    /// Number of failures one after the other; a success sets it to zero.
    pub(crate) failures: u32,
    /// Largest penalty that led nowhere, so that it is not tried again.
    pub(crate) tried: f64,
}

impl Parts {
    /// The path before its first part, which takes the fraction `longest`.
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

    /// Takes `next` as reached by a snap-through; the next part is as long as that was.
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

    /// Half of what the next part takes.
    pub(crate) fn half(&self) -> f64 {
        0.5 * (self.next() - self.reached)
    }

    /// Halves what the next part takes, after a failure.
    pub(crate) fn cut_back(&mut self) {
        self.part = self.half();
    }
}
