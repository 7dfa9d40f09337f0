//! When the approximate inverse of the tangent is made anew: where a program takes
//! more than three times the applications a decade of the first program with the
//! present one. A rule on counts, the same on every machine. A tangent whose P1
//! block has no factor leaves things as they are, with the next count as the
//! new measure, so that it is not asked for again and again.

use std::sync::Arc;

use crate::prepare::ApproximateInverse;

constants! {
    /// Applications a decade, over those of the first program, that are too many.
    const DEAR: f64 = 3.0;
    /// Reductions below this say little of a rate.
    const LEAST_DECADES: f64 = 0.5;
}

/// The approximate inverse in use and what it costs.
#[derive(Clone, Debug, Default)]
pub(crate) struct PreconditionerRefresh {
    /// The approximate inverse made last; none stands for that at rest.
    made: Option<Arc<ApproximateInverse>>,
    /// Applications that its first program needed for each decade of the residual; none
    /// before that program.
    fresh: Option<f64>,
    /// Applications that the last program needed for each decade of the residual.
    last: f64,
    /// Whether the last tangent had no factor, so that another attempt waits for the
    /// state to change.
    refused: bool,
}

impl PreconditionerRefresh {
    /// Bytes held by this session alone.
    pub(crate) fn bytes(&self) -> u64 {
        self.made.as_ref().map_or(0, |made| made.bytes())
    }

    /// Notes what a program took to reduce its residual from `start` to `end`.
    pub(crate) fn note(&mut self, applications: u32, start: f64, end: f64) {
        let decades = (start / end).log10();
        if decades > LEAST_DECADES {
            self.last = f64::from(applications) / decades;
            self.fresh.get_or_insert(self.last);
        }
    }

    /// Asks for a new one, for another operator.
    pub(crate) fn renew(&mut self) {
        self.last = f64::INFINITY;
        self.fresh = Some(1.0);
        self.refused = false;
    }

    /// Whether the one in use has become too dear.
    pub(crate) fn is_stale(&self) -> bool {
        self.fresh.is_some_and(|fresh| self.last > DEAR * fresh)
    }

    /// The one in use; none for that at rest.
    pub(crate) fn made(&self) -> Option<Arc<ApproximateInverse>> {
        self.made.clone()
    }

    /// Takes a new one into use.
    pub(crate) fn take(&mut self, made: ApproximateInverse) {
        self.made = Some(Arc::new(made));
        self.fresh = None;
        self.refused = false;
    }

    /// Notes that the present tangent has none.
    pub(crate) fn refuse(&mut self) {
        self.fresh = None;
        self.refused = true;
    }
}
