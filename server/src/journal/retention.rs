//! Which results the data folder need not keep: too old, or too many bytes in all.
//!
//! A session's newest result stays, and so do those that a replay needs, behind its
//! checkpoint. Old ones go first, whoever's they are.

use std::collections::BTreeMap;

use redb::{Database, ReadableDatabase, ReadableTable};

use super::database::{CHECKPOINTS, RESULTS};
use super::error::JournalError;
use super::record::{StoredCheckpoint, StoredResult, opened};

/// What may stay.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limit {
    /// Bytes of all results with their fields.
    pub(crate) bytes: u64,
    /// Unix seconds before which a result is too old.
    pub(crate) oldest: i64,
}

/// One result of a session.
struct One {
    event: i64,
    made: i64,
    bytes: u64,
}

/// For each session whose results shall go, the first event that stays.
pub(super) fn outdated(
    database: &Database,
    limit: Limit,
) -> Result<BTreeMap<String, i64>, JournalError> {
    let (mut all, total) = droppable(database)?;
    all.sort_by_key(|(_, one)| one.made);
    let mut kept = total;
    let mut first = BTreeMap::new();
    for (name, one) in all {
        if one.made >= limit.oldest && kept <= limit.bytes {
            break;
        }
        kept -= one.bytes;
        let stays = first.entry(name).or_insert(0);
        *stays = one.event.max(*stays - 1) + 1;
    }
    Ok(first)
}

/// The results that may go, and the bytes of all.
fn droppable(database: &Database) -> Result<(Vec<(String, One)>, u64), JournalError> {
    let read = database.begin_read()?;
    let checkpoints = read.open_table(CHECKPOINTS)?;
    let results = read.open_table(RESULTS)?;
    let (mut found, mut total) = (Vec::new(), 0);
    for entry in checkpoints.iter()? {
        let (name, checkpoint) = entry?;
        let name = name.value();
        let behind = opened::<StoredCheckpoint>(checkpoint.value(), name)?.event;
        let newest = results
            .range((name, i64::MIN)..=(name, i64::MAX))?
            .next_back();
        let newest = newest.transpose()?.map_or(0, |(key, _)| key.value().1);
        for entry in results.range((name, i64::MIN)..=(name, behind.min(newest - 1)))? {
            let (key, value) = entry?;
            let result = opened::<StoredResult>(value.value(), name)?;
            let one = One {
                event: key.value().1,
                made: result.made,
                bytes: value.value().len() as u64 + result.field_bytes,
            };
            total += one.bytes;
            found.push((name.to_owned(), one));
        }
    }
    Ok((found, total))
}
