//! What the journal knows of a session, in the terms of sessions.

use prost::Message as _;
use signorini_proto::v1::{self as wire, solve_request};

use crate::convert::field::{self, KeptField};
use crate::convert::step::{self, Update};
use crate::fault::Fault;
use crate::journal::{Stored, StoredCheckpoint, StoredField, StoredFields, StoredResult};
use crate::results::kept::{KeptReport, KeptResult};

/// A session that goes on.
pub(crate) struct Recovered {
    /// Accepted updates after the checkpoint, in sequence, and whether they shall stop.
    pub(super) updates: Vec<(Update, bool)>,
    /// Kept results, oldest first.
    pub(super) results: Vec<KeptResult>,
    /// Where the state comes from; the beginning without one.
    pub(crate) checkpoint: Option<StoredCheckpoint>,
    /// States to go back to, by number.
    pub(super) saves: Vec<(i64, bytes::Bytes)>,
}

impl Recovered {
    /// The beginning of a session that goes on from the state of another one.
    pub(crate) fn at(state: bytes::Bytes) -> Self {
        let checkpoint = StoredCheckpoint {
            state,
            ..StoredCheckpoint::default()
        };
        Self {
            updates: Vec::new(),
            results: Vec::new(),
            checkpoint: Some(checkpoint),
            saves: Vec::new(),
        }
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
            let read = read_update(&update.encoded).ok_or_else(|| damaged("an update"))?;
            updates.push((read, update.cancelled));
        }
        let mut results = Vec::with_capacity(stored.results.len());
        for (event, result, fields) in stored.results {
            let read = read_result(event, result, fields);
            results.push(read.ok_or_else(|| damaged("a result"))?);
        }
        Ok(Self {
            updates,
            results,
            checkpoint: stored.checkpoint,
            saves: (stored.saves.into_iter())
                .map(|(number, save)| (number, save.state))
                .collect(),
        })
    }
}

fn read_update(encoded: &bytes::Bytes) -> Option<Update> {
    let request = wire::SolveRequest::decode(encoded.clone()).ok()?;
    match request.message? {
        solve_request::Message::LoadStep(update) => step::load_step(&update, encoded.clone()),
        solve_request::Message::ObstacleUpdate(update) => {
            step::obstacle_update(update, encoded.clone())
        }
        solve_request::Message::Open(_) | solve_request::Message::Cancel(_) => return None,
    }
    .ok()
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
