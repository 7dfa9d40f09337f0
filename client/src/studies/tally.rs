//! How the cases of a run have ended so far.

use std::collections::BTreeMap;

use super::row::Row;

/// Counts of rows.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    counts: BTreeMap<String, u64>,
    seconds: f64,
    /// The first that is seen of each kind of failure.
    first: BTreeMap<String, (u64, String)>,
}

impl Tally {
    /// Adds a row.
    pub(crate) fn add(&mut self, row: &Row) {
        *self.counts.entry(row.termination.clone()).or_default() += 1;
        self.seconds += row.seconds;
        if !row.is_converged() {
            let told = [row.cause.as_deref(), row.message.as_deref()];
            let told: Vec<&str> = told.into_iter().flatten().collect();
            let first = (row.case, told.join(": "));
            self.first.entry(row.termination.clone()).or_insert(first);
        }
    }

    /// Rows without values.
    pub(crate) fn failures(&self) -> u64 {
        let all: u64 = self.counts.values().sum();
        all - self
            .counts
            .get(super::row::CONVERGED)
            .copied()
            .unwrap_or_default()
    }

    /// A line for each way to end, with an example where it is a failure.
    pub(crate) fn lines(&self) -> Vec<String> {
        let line = |(termination, count): (&String, &u64)| match self.first.get(termination) {
            Some((case, why)) => format!("{termination:<18} {count}, such as case {case}: {why}\n"),
            None => format!("{termination:<18} {count}\n"),
        };
        let mut lines: Vec<String> = self.counts.iter().map(line).collect();
        lines.push(format!("{:<18} {:.1} s\n", "solver", self.seconds));
        lines
    }
}
