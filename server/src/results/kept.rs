//! Results that a session keeps, so that readers may come late or twice.
//!
//! Reports are kept up to a count, their fields up to a number of bytes; the
//! newest result always keeps its fields.

use std::collections::VecDeque;
use std::sync::Arc;

use bytes::Bytes;
use prost::Message as _;
use signorini::report::FieldName;
use signorini_proto::v1 as wire;

use crate::convert::field::{self, Encoding, KeptField};

/// Bytes of one result beside its encoded report and its fields.
const OVERHEAD_BYTES: u64 = 256;

/// A report as it is kept: encoded, which takes a tenth of its structure.
#[derive(Clone, Debug)]
pub(crate) struct KeptReport {
    pub(crate) increment: i32,
    encoded: Bytes,
}

impl From<&wire::StepReport> for KeptReport {
    fn from(report: &wire::StepReport) -> Self {
        Self {
            increment: report.increment,
            encoded: report.encode_to_vec().into(),
        }
    }
}

impl KeptReport {
    /// As it was encoded before.
    pub(crate) fn from_encoded(encoded: Bytes) -> Option<Self> {
        let report = wire::StepReport::decode(encoded.clone()).ok()?;
        let increment = report.increment;
        Some(Self { increment, encoded })
    }

    pub(crate) fn encoded(&self) -> Bytes {
        self.encoded.clone()
    }

    pub(crate) fn decode(&self) -> Option<wire::StepReport> {
        // It was encoded here, so it decodes.
        wire::StepReport::decode(self.encoded.clone()).ok()
    }

    fn bytes(&self) -> u64 {
        self.encoded.len() as u64
    }
}

/// One result.
#[derive(Clone, Debug)]
pub(crate) struct KeptResult {
    pub(crate) sequence: i64,
    pub(crate) event: i64,
    pub(crate) report: KeptReport,
    /// The last one of its sequence.
    pub(crate) last: bool,
    /// Fields that were asked for when it was made; the scene may lack some.
    /// `None` for an increment that brings no fields.
    pub(crate) asked: Option<Vec<FieldName>>,
    pub(crate) fields: Vec<KeptField>,
    /// Its fields left retention.
    pub(crate) dropped: bool,
    /// Change of the session's journal that has to be on disk before anybody sees it.
    pub(crate) needs: u64,
}

impl KeptResult {
    fn field_bytes(&self) -> u64 {
        self.fields
            .iter()
            .map(|field| field.data.len() as u64)
            .sum()
    }

    /// Bytes that it keeps in memory.
    pub(crate) fn bytes(&self) -> u64 {
        self.field_bytes() + self.report_bytes()
    }

    /// Its fields, if it is the result of that event.
    pub(crate) fn fields_at(&self, event: i64) -> Vec<KeptField> {
        let is_meant = self.event == event;
        if is_meant {
            self.fields.clone()
        } else {
            Vec::new()
        }
    }

    fn report_bytes(&self) -> u64 {
        self.report.bytes() + OVERHEAD_BYTES
    }

    fn without_fields(&self) -> Self {
        Self {
            dropped: !self.fields.is_empty(),
            fields: Vec::new(),
            ..self.clone()
        }
    }
}

/// The messages of a result with the fields that a reader wants.
pub(crate) fn messages(
    result: &KeptResult,
    wanted: &[FieldName],
    encoding: Encoding,
) -> (
    wire::StepFinished,
    impl Iterator<Item = wire::FieldChunk> + use<>,
) {
    let found = |name: &FieldName| result.fields.iter().find(|field| field.name == *name);
    let fields: Vec<KeptField> = wanted.iter().filter_map(found).cloned().collect();
    let made =
        |asked: &Vec<FieldName>| !result.dropped && wanted.iter().all(|one| asked.contains(one));
    let finished = wire::StepFinished {
        sequence: result.sequence,
        event: result.event,
        report: result.report.decode(),
        last: result.last,
        fields: fields
            .iter()
            .map(|one| field::name(one.name).into())
            .collect(),
        fields_dropped: !result.asked.as_ref().is_none_or(made),
    };
    let (sequence, event) = (result.sequence, result.event);
    let chunks = fields
        .into_iter()
        .flat_map(move |field| field.chunks(sequence, event, encoding));
    (finished, chunks)
}

/// The results of one session, oldest first.
#[derive(Debug)]
pub(crate) struct Kept {
    results: VecDeque<Arc<KeptResult>>,
    field_bytes: u64,
    report_bytes: u64,
    maximum_results: usize,
    maximum_field_bytes: u64,
    /// Last change of the session's journal that is on disk.
    durable: u64,
}

impl Kept {
    pub(crate) fn new(maximum_results: usize, maximum_field_bytes: u64) -> Self {
        Self {
            results: VecDeque::new(),
            field_bytes: 0,
            report_bytes: 0,
            maximum_results,
            maximum_field_bytes,
            durable: u64::MAX,
        }
    }

    /// Shows results that need a change of the journal up to `mark`, and no others.
    pub(crate) fn show(&mut self, mark: u64) {
        self.durable = mark;
    }

    fn is_shown(&self, result: &KeptResult) -> bool {
        result.needs <= self.durable
    }

    /// The newest result that readers see; `newest` without results.
    pub(crate) fn shown_event(&self, newest: i64) -> i64 {
        match self.first_hidden() {
            Some(hidden) => hidden.event - 1,
            None => newest,
        }
    }

    /// The first result that waits for the disk.
    pub(crate) fn first_hidden(&self) -> Option<&Arc<KeptResult>> {
        // Later results need later changes.
        let first = self.results.partition_point(|one| self.is_shown(one));
        self.results.get(first)
    }

    /// Keeps a result and drops what no longer fits.
    pub(crate) fn push(&mut self, result: KeptResult) -> Arc<KeptResult> {
        let result = Arc::new(result);
        self.field_bytes += result.field_bytes();
        self.report_bytes += result.report_bytes();
        self.results.push_back(Arc::clone(&result));
        while self.results.len() > self.maximum_results {
            self.drop_oldest();
        }
        self.drop_fields();
        result
    }

    fn drop_fields(&mut self) {
        self.shrink(self.maximum_field_bytes);
    }

    /// Drops the fields of the oldest results until the rest have at most
    /// `most_bytes`; the newest result keeps its own.
    fn shrink(&mut self, most_bytes: u64) {
        let older = self.results.len().saturating_sub(1);
        for result in self.results.iter_mut().take(older) {
            if self.field_bytes <= most_bytes {
                return;
            }
            if !result.fields.is_empty() {
                self.field_bytes -= result.field_bytes();
                *result = Arc::new(result.without_fields());
            }
        }
    }

    pub(crate) fn newest(&self) -> Option<&Arc<KeptResult>> {
        self.results.back()
    }

    /// Results of one sequence.
    pub(crate) fn of_sequence(&self, sequence: i64) -> Vec<Arc<KeptResult>> {
        let wanted =
            |result: &&Arc<KeptResult>| result.sequence == sequence && self.is_shown(result);
        self.results.iter().filter(wanted).cloned().collect()
    }

    /// Where a reader starts that has seen the events up to `seen`; without, it
    /// starts after `newest`.
    pub(crate) fn seen(&self, seen: Option<i64>, newest: i64) -> i64 {
        let oldest = self.results.front().map_or(newest, |one| one.event - 1);
        seen.map_or(newest, |seen| seen.max(oldest).min(newest))
    }

    /// The oldest result with an event above `event`, if readers see it.
    pub(crate) fn after(&self, event: i64) -> Option<&Arc<KeptResult>> {
        // Events have no gaps, so the position follows from the number.
        let oldest = self.results.front()?.event;
        let position = usize::try_from(event + 1 - oldest).unwrap_or(0);
        self.results
            .get(position)
            .filter(|result| self.is_shown(result))
    }

    /// First and last event of a sequence.
    pub(crate) fn events_of(&self, sequence: i64) -> Option<(i64, i64)> {
        let first = self.results.partition_point(|one| one.sequence < sequence);
        let seen = |one: &Arc<KeptResult>| one.sequence <= sequence && self.is_shown(one);
        let end = self.results.partition_point(seen);
        let last = self.results.get(end.checked_sub(1)?)?;
        Some((self.results.get(first)?.event, last.event)).filter(|_| first < end)
    }

    /// First sequence of which every result is kept; 0 without results.
    pub(crate) fn first_sequence(&self) -> i64 {
        match self.results.front() {
            Some(oldest) if oldest.report.increment <= 1 => oldest.sequence,
            Some(oldest) => oldest.sequence + 1,
            None => 0,
        }
    }

    /// Event of the oldest result that has fields.
    pub(crate) fn first_with_fields(&self) -> Option<i64> {
        let mut all = self.results.iter();
        all.find(|one| !one.fields.is_empty()).map(|one| one.event)
    }

    /// Bytes of reports and fields.
    pub(crate) fn bytes(&self) -> u64 {
        self.field_bytes + self.report_bytes
    }

    /// Frees `bytes` as far as the newest result allows: the fields of the oldest
    /// results first, then whole old results.
    pub(crate) fn free(&mut self, bytes: u64) {
        let most = self.bytes().saturating_sub(bytes);
        self.shrink(self.field_bytes.saturating_sub(bytes));
        while self.bytes() > most && self.results.len() > 1 {
            self.drop_oldest();
        }
    }

    fn drop_oldest(&mut self) {
        if let Some(oldest) = self.results.pop_front() {
            self.field_bytes -= oldest.field_bytes();
            self.report_bytes -= oldest.report_bytes();
        }
    }
}

#[cfg(test)]
mod tests {
    use signorini::report::FieldData;

    use super::*;

    fn result(event: i64, values: usize) -> KeptResult {
        let field = FieldData {
            name: FieldName::Gap,
            components: 1,
            values: vec![1.0; values],
        };
        KeptResult {
            sequence: event,
            event,
            report: KeptReport::from(&wire::StepReport {
                increment: 1,
                ..Default::default()
            }),
            last: true,
            asked: Some(vec![FieldName::Gap, FieldName::Pressure]),
            fields: vec![KeptField::new(&field)],
            dropped: false,
            needs: 0,
        }
    }

    #[test]
    fn old_fields_go_first_and_the_newest_stay_even_when_too_large() {
        let mut kept = Kept::new(10, 100);
        for event in 1..=3 {
            kept.push(result(event, 10));
        }
        assert_eq!(kept.field_bytes, 80);
        let dropped = [0, 1, 2].map(|event| kept.after(event).unwrap().dropped);
        assert_eq!(dropped, [true, true, false]);
    }

    #[test]
    fn whole_results_go_where_fields_alone_do_not_free_enough() {
        let mut kept = Kept::new(10, 1000);
        for event in 1..=3 {
            kept.push(result(event, 10));
        }
        let all = kept.bytes();
        kept.free(160);
        assert_eq!((kept.field_bytes, kept.first_sequence()), (80, 1));
        kept.free(all);
        assert_eq!((kept.field_bytes, kept.first_sequence()), (80, 3));
    }

    #[test]
    fn old_results_go_beyond_the_count() {
        let mut kept = Kept::new(2, 1000);
        for event in 1..=3 {
            kept.push(result(event, 1));
        }
        assert_eq!((kept.first_sequence(), kept.field_bytes), (2, 16));
        assert_eq!(kept.of_sequence(1).len(), 0);
        assert_eq!(kept.of_sequence(3).len(), 1);
    }

    #[test]
    fn results_are_found_by_their_events() {
        let mut kept = Kept::new(3, 1000);
        for event in 1..=4 {
            let sequence = (event + 1) / 2;
            kept.push(KeptResult {
                sequence,
                ..result(event, 1)
            });
        }
        let later = |event| kept.after(event).map(|one| one.event);
        assert_eq!(
            [0, 1, 2, 3, 4].map(later),
            [2, 2, 3, 4]
                .map(Some)
                .into_iter()
                .chain([None])
                .collect::<Vec<_>>()[..]
        );
        assert_eq!(kept.events_of(1), Some((2, 2)));
        assert_eq!(kept.events_of(2), Some((3, 4)));
        assert_eq!((kept.events_of(0), kept.events_of(3)), (None, None));
    }

    #[test]
    fn messages_name_the_fields_that_follow_and_those_that_are_gone() {
        let kept = result(1, 4);
        let ask = |result: &KeptResult, wanted: &[FieldName]| {
            let (finished, chunks) = messages(result, wanted, Encoding::Double);
            (
                finished.fields.len(),
                finished.fields_dropped,
                chunks.count(),
            )
        };
        assert_eq!(ask(&kept, &[FieldName::Gap]), (1, false, 1));
        // The scene has no pressure: asked for, not there, not dropped.
        assert_eq!(ask(&kept, &[FieldName::Pressure]), (0, false, 0));
        assert_eq!(ask(&kept, &[FieldName::Stress]), (0, true, 0));
        assert_eq!(ask(&kept.without_fields(), &[FieldName::Gap]), (0, true, 0));
        let skipped = KeptResult {
            asked: None,
            fields: Vec::new(),
            ..kept
        };
        assert_eq!(ask(&skipped, &[FieldName::Gap]), (0, false, 0));
    }
}
