//! What a session's client knows: what it sent and every result it was told.

use std::collections::{BTreeMap, BTreeSet};

use prost::Message as _;
use signorini_proto::v1 as wire;

/// Results of one session over all its streams, and the updates sent to it.
#[derive(Default)]
pub(crate) struct Journal {
    /// By event: sequence, whether it is the last, the encoded report.
    results: BTreeMap<i64, (i64, bool, Vec<u8>)>,
    /// Sequences sent on the stream that is open, and those answered on it.
    asked: BTreeSet<i64>,
    answered: BTreeSet<i64>,
    /// Sequences sent on any stream.
    ever_asked: BTreeSet<i64>,
    newest: i64,
    sent: u64,
    updates: usize,
    rejections: usize,
}

impl Journal {
    /// A stream opens; `last_event` is the newest result until now.
    pub(crate) fn opened(&mut self, last_event: i64) {
        self.asked.clear();
        self.answered.clear();
        assert!(
            last_event >= self.newest,
            "{last_event} after {}",
            self.newest
        );
        self.newest = last_event;
    }

    /// A message went out, with a sequence if it is an update.
    pub(crate) fn message(&mut self, sequence: Option<i64>) {
        self.sent += 1;
        self.asked.extend(sequence);
        self.ever_asked.extend(sequence);
        self.updates += usize::from(sequence.is_some());
    }

    /// Messages sent, results told, rejections told.
    pub(crate) fn totals(&self) -> [u64; 3] {
        [self.sent, self.results.len() as u64, self.rejections as u64]
    }

    /// The newest event that was told.
    pub(crate) fn last_seen(&self) -> i64 {
        self.results.keys().next_back().copied().unwrap_or(0)
    }

    /// New results are gapless, old ones are told as before.
    pub(crate) fn result(&mut self, one: &wire::StepFinished) {
        let report = one.report.as_ref().unwrap().encode_to_vec();
        let entry = (one.sequence, one.last, report);
        if one.event > self.newest {
            assert_eq!(one.event, self.newest + 1, "results have no gap");
            self.newest = one.event;
        }
        if let Some(before) = self.results.insert(one.event, entry.clone()) {
            assert_eq!(before, entry, "event {} is told otherwise", one.event);
        }
        if one.last {
            self.answered.insert(one.sequence);
        }
    }

    pub(crate) fn rejection(&mut self, one: &wire::UpdateRejected) {
        assert!(
            self.ever_asked.contains(&one.sequence),
            "nobody sent {}",
            one.sequence
        );
        assert!(one.status.is_some());
        self.rejections += 1;
        assert!(self.rejections <= self.updates);
        self.answered.insert(one.sequence);
    }

    /// Every update of a stream that ended well was answered on it.
    pub(crate) fn check_answers(&self) {
        let open: Vec<_> = self.asked.difference(&self.answered).collect();
        assert!(open.is_empty(), "no answer to {open:?}");
    }

    /// All results are known, and each finished sequence has one last result.
    pub(crate) fn check_complete(&self, last_finished: i64) {
        let events: Vec<i64> = self.results.keys().copied().collect();
        assert_eq!(events, (1..=self.newest).collect::<Vec<_>>());
        let lasts = self.results.values().filter(|(_, last, _)| *last);
        let lasts: Vec<i64> = lasts.map(|(sequence, _, _)| *sequence).collect();
        assert_eq!(lasts, (1..=last_finished).collect::<Vec<_>>());
    }
}

/// A journal that told nothing would pass everything.
mod tests {
    use super::*;

    fn result(event: i64, sequence: i64) -> wire::StepFinished {
        wire::StepFinished {
            sequence,
            event,
            report: Some(wire::StepReport::default()),
            last: true,
            ..Default::default()
        }
    }

    #[test]
    #[should_panic(expected = "results have no gap")]
    fn a_missing_result_is_noticed() {
        Journal::default().result(&result(2, 1));
    }

    #[test]
    #[should_panic(expected = "told otherwise")]
    fn a_result_that_changes_is_noticed() {
        let mut journal = Journal::default();
        journal.result(&result(1, 1));
        journal.result(&result(1, 2));
    }

    #[test]
    #[should_panic(expected = "no answer to [1]")]
    fn an_unanswered_update_is_noticed() {
        let mut journal = Journal::default();
        journal.message(Some(1));
        journal.check_answers();
    }

    #[test]
    #[should_panic(expected = "left == right")]
    fn a_second_last_result_is_noticed() {
        let mut journal = Journal::default();
        journal.result(&result(1, 1));
        journal.result(&result(2, 1));
        journal.check_complete(1);
    }
}
