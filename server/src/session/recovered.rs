//! What the journal knows of a session, in the terms of sessions.

use super::replay::{self, ReplayStep};
use crate::convert::field::{self, KeptField};
use crate::convert::step::Update;
use crate::fault::Fault;
use crate::journal::{
    Stored, StoredCheckpoint, StoredField, StoredFields, StoredResult, StoredSave,
};
use crate::results::kept::{KeptReport, KeptResult};

/// A session that goes on.
pub(crate) struct Recovered {
    /// Accepted updates after the checkpoint, in sequence, and whether they shall stop.
    pub(super) updates: Vec<(Update, bool)>,
    /// Kept results, oldest first.
    pub(super) results: Vec<KeptResult>,
    /// Where the state comes from; the beginning without one.
    pub(crate) checkpoint: Option<StoredCheckpoint>,
    /// What was done on that state before it was the checkpoint's.
    pub(super) since: Vec<ReplayStep>,
    /// States to go back to, by number.
    pub(super) saves: Vec<(i64, StoredSave)>,
}

impl Recovered {
    /// The beginning of a session that goes on from the state of another one.
    ///
    /// # Errors
    /// `StateInvalid` for what no session exports.
    pub(crate) fn at(exported: StoredSave) -> Result<Self, Fault> {
        let since = ReplayStep::all_again(&exported.since);
        let wrong = || Fault::StateInvalid("what was done on the state cannot be read".to_owned());
        let since = since.ok_or_else(wrong)?;
        let checkpoint = StoredCheckpoint {
            state: exported.state,
            since: exported.since,
            ..StoredCheckpoint::default()
        };
        Ok(Self {
            updates: Vec::new(),
            results: Vec::new(),
            checkpoint: Some(checkpoint),
            since,
            saves: Vec::new(),
        })
    }

    /// Reads what was stored of the session `name`.
    ///
    /// # Errors
    /// `SessionDamaged` for what no server stores.
    pub(crate) fn new(name: &str, stored: Stored) -> Result<Self, Fault> {
        let damaged = |what: &str| Fault::SessionDamaged {
            name: name.to_owned(),
            why: format!("{what} cannot be read"),
        };
        let mut updates = Vec::with_capacity(stored.updates.len());
        for (_, update) in stored.updates {
            let read = replay::read_update(&update.encoded).ok_or_else(|| damaged("an update"))?;
            updates.push((read, update.cancelled));
        }
        let mut results = Vec::with_capacity(stored.results.len());
        for (event, result, fields) in stored.results {
            let read = read_result(event, result, fields);
            results.push(read.ok_or_else(|| damaged("a result"))?);
        }
        let checkpoint = stored.checkpoint;
        let since = checkpoint.as_ref().map_or(&[][..], |one| &one.since);
        let since = ReplayStep::all_again(since).ok_or_else(|| damaged("a checkpoint"))?;
        for (_, save) in &stored.saves {
            ReplayStep::all_again(&save.since).ok_or_else(|| damaged("a saved state"))?;
        }
        Ok(Self {
            updates,
            results,
            checkpoint,
            since,
            saves: stored.saves,
        })
    }
}

fn read_result(event: i64, result: StoredResult, fields: StoredFields) -> Option<KeptResult> {
    let fields: Option<Vec<_>> = fields.fields.into_iter().map(read_field).collect();
    let fields = fields?;
    let asked = field::names(&result.asked, "asked").ok()?;
    Some(KeptResult {
        sequence: result.sequence,
        event,
        report: KeptReport::from_encoded(result.report)?,
        last: result.last,
        asked: result.is_due.then_some(asked),
        dropped: fields.is_empty() && result.field_bytes > 0,
        fields,
        needs: 0,
    })
}

fn read_field(stored: StoredField) -> Option<KeptField> {
    KeptField::from_parts(stored.name, (stored.rows, stored.components), stored.data)
}

/// A result as it is stored, with its fields.
pub(super) fn stored(result: &KeptResult, made: i64) -> (StoredResult, StoredFields) {
    let asked = result.asked.iter().flatten();
    let one = |field: &KeptField| {
        let (rows, components) = field.shape();
        StoredField {
            name: field::name(field.name).into(),
            rows,
            components,
            data: field.data.clone(),
        }
    };
    let fields: Vec<StoredField> = result.fields.iter().map(one).collect();
    let stored = StoredResult {
        sequence: result.sequence,
        report: result.report.encoded(),
        last: result.last,
        is_due: result.asked.is_some(),
        asked: asked.map(|name| field::name(*name).into()).collect(),
        field_bytes: fields.iter().map(|field| field.data.len() as u64).sum(),
        made,
    };
    (stored, StoredFields { fields })
}
