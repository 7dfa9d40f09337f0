//! Dual solutions of goals at the last increments, where those of the next one begin.
//!
//! `[goals][increments]`, the latest first. Memory: a vector of all unknowns each.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::fields::Fields;

constants! {
    /// Dual solutions of a goal that are kept: two follow what is linear in the load, three what bends.
    const MOST_KNOWN: usize = 3;
    /// Goals whose dual solutions are kept.
    const MOST_GOALS: usize = 8;
}

/// Dual solutions of the last increments, the latest first, by goal: where the next ones begin.
#[derive(Clone, Debug, Default)]
pub(crate) struct KnownDuals(BTreeMap<String, Vec<Arc<Fields>>>);

impl KnownDuals {
    /// Those of a goal.
    pub(crate) fn of(&self, goal: &str) -> Vec<Arc<Fields>> {
        self.0.get(goal).cloned().unwrap_or_default()
    }

    /// Takes those of one more increment.
    pub(crate) fn add(&mut self, duals: Vec<(String, Fields)>) {
        for (goal, fields) in duals.into_iter().take(MOST_GOALS) {
            let own = self.0.entry(goal).or_default();
            own.insert(0, Arc::new(fields));
            own.truncate(MOST_KNOWN);
        }
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        self.0.values().flatten().map(|own| own.bytes()).sum()
    }
}
