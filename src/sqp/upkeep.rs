//! When the approximate inverse of the tangent is made anew: where a program takes
//! more than three times the applications a decade of the first program with the
//! present one. A rule on counts, the same on every machine. A tangent whose P1
//! block has no factor leaves things as they are, with the next count as the
//! new measure, so that it is not asked for again and again.

use std::sync::Arc;

use super::counters::{Counters, timed};
use super::evaluate::Context;
use super::state::State;
use super::tangent::Tangent;
use super::watch::Watch;
use crate::plan::{Approximation, Deformed};

/// Applications a decade, over those of the first program, that are too many.
const DEAR: f64 = 3.0;
/// Reductions below this say little of a rate.
const LEAST_DECADES: f64 = 0.5;

/// The approximate inverse in use and what it costs.
#[derive(Debug, Default)]
pub(crate) struct Upkeep {
    /// None for that at rest.
    made: Option<Arc<Approximation>>,
    /// Applications a decade of its first program.
    fresh: Option<f64>,
    /// Applications a decade of the last program.
    last: f64,
    /// Whether the last tangent had no factor.
    refused: bool,
}

impl Upkeep {
    /// Bytes held by this session alone.
    pub(crate) fn bytes(&self) -> u64 {
        self.made.as_ref().map_or(0, |made| made.bytes())
    }

    /// Notes what a program took to reduce its residual from `start` to `end`.
    pub(super) fn note(&mut self, applications: u32, start: f64, end: f64) {
        let decades = (start / end).log10();
        if decades > LEAST_DECADES {
            self.last = f64::from(applications) / decades;
            self.fresh.get_or_insert(self.last);
        }
    }

    /// Asks for a new one after a program that failed; whether there may be a better
    /// one than that which failed.
    pub(super) fn failed(&mut self, was_new: bool) -> bool {
        let may_help = !was_new && !self.refused;
        if may_help {
            self.last = f64::INFINITY;
            self.fresh.get_or_insert(1.0);
        }
        may_help
    }

    /// Asks for a new one, for another operator.
    pub(super) fn renew(&mut self) {
        self.last = f64::INFINITY;
        self.fresh = Some(1.0);
        self.refused = false;
    }

    fn is_stale(&self) -> bool {
        self.fresh.is_some_and(|fresh| self.last > DEAR * fresh)
    }
}

/// The approximate inverse for a program about the present state.
pub(super) fn inverse(
    context: &Context<'_>,
    state: &mut State,
    tangent: Option<&Tangent>,
    watch: &Watch<'_>,
    counters: &mut Counters,
) -> Arc<Approximation> {
    if let Some(tangent) = tangent.filter(|_| state.upkeep.is_stale()) {
        make(context, state, tangent, watch, counters);
    }
    let made = state.upkeep.made.clone();
    made.unwrap_or_else(|| context.prepared.at_rest.clone())
}

fn make(
    context: &Context<'_>,
    state: &mut State,
    tangent: &Tangent,
    watch: &Watch<'_>,
    counters: &mut Counters,
) {
    let deformed = Deformed {
        cells: &tangent.stiffness.free.cells,
        at: &tangent.stiffness.free.at,
        displacement: &state.displacement,
        pressure: &state.pressure,
    };
    let prepared = context.prepared;
    let made = timed(&mut counters.seconds.factorise, || {
        prepared.about(context.plan, context.mesh, deformed, watch.cancel)
    });
    match made {
        Ok(made) => {
            counters.factorisations += 1;
            state.upkeep.made = Some(Arc::new(made));
            state.upkeep.fresh = None;
            state.upkeep.refused = false;
        }
        // A cancelled one is noticed by the next iteration.
        Err(_) => {
            state.upkeep.fresh = None;
            state.upkeep.refused = true;
        }
    }
}
