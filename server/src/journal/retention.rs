//! Which results and imported states the data folder need not keep: too old, or too many
//! bytes in all.
//!
//! A session's newest result stays, and so do those that a replay needs, after its
//! checkpoint. Old ones go first, whoever's they are.

use std::collections::BTreeMap;

use redb::{Database, ReadableDatabase, ReadableTable};

use super::database::{CHECKPOINTS, RESULTS, states};
use super::error::JournalError;
use super::record::{StoredCheckpoint, StoredResult, opened};
use crate::config::Limit;

/// What shall go.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Outdated {
    /// For each session whose results shall go, the first event that stays.
    pub(super) results: BTreeMap<String, i64>,
    /// Digests of states.
    pub(super) states: Vec<String>,
}

/// What may go.
struct One {
    what: What,
    /// Unix milliseconds.
    made: i64,
    bytes: u64,
}

enum What {
    /// Of a session, its event.
    Result(String, i64),
    State(String),
}

/// What the limit does not allow to stay.
pub(super) fn outdated(database: &Database, limit: Limit) -> Result<Outdated, JournalError> {
    let mut all = droppable(database)?;
    all.extend(states(database)?.into_iter().map(|(digest, state)| One {
        what: What::State(digest),
        made: state.made,
        bytes: state.bytes,
    }));
    all.sort_by_key(|one| one.made);
    let mut kept: u64 = all.iter().map(|one| one.bytes).sum();
    let mut found = Outdated::default();
    let oldest = limit.oldest.saturating_mul(1000);
    for one in all {
        if one.made >= oldest && kept <= limit.bytes {
            break;
        }
        kept -= one.bytes;
        match one.what {
            What::Result(name, event) => {
                let stays = found.results.entry(name).or_insert(0);
                *stays = event.max(*stays - 1) + 1;
            }
            What::State(digest) => found.states.push(digest),
        }
    }
    Ok(found)
}

/// The results that may go.
fn droppable(database: &Database) -> Result<Vec<One>, JournalError> {
    let read = database.begin_read()?;
    let checkpoints = read.open_table(CHECKPOINTS)?;
    let results = read.open_table(RESULTS)?;
    let mut found = Vec::new();
    for entry in checkpoints.iter()? {
        let (name, checkpoint) = entry?;
        let name = name.value();
        let checkpointed = opened::<StoredCheckpoint>(checkpoint.value(), name)?.event;
        let newest = results
            .range((name, i64::MIN)..=(name, i64::MAX))?
            .next_back();
        let newest = newest.transpose()?.map_or(0, |(key, _)| key.value().1);
        for entry in results.range((name, i64::MIN)..=(name, checkpointed.min(newest - 1)))? {
            let (key, value) = entry?;
            let result = opened::<StoredResult>(value.value(), name)?;
            found.push(One {
                what: What::Result(name.to_owned(), key.value().1),
                made: result.made.saturating_mul(1000),
                bytes: value.value().len() as u64 + result.field_bytes,
            });
        }
    }
    Ok(found)
}
