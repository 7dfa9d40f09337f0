//! Changes as one record of a stream that other servers read, too.
//!
//! Where there is a fence, a change of a session is the fleet's first and this folder's then: one
//! that the fence refuses is not stored here either.

use std::sync::Arc;

use bytes::Bytes;
use prost::{Message, Oneof};

use super::error::JournalError;
use super::record::{
    StoredCheckpoint, StoredFields, StoredResult, StoredSave, StoredSession, StoredUpdate,
};
use super::{Change, Journal, Stored, database};

/// Where changes go first.
pub(crate) trait Fence: Send + Sync {
    /// Stores records of sessions; one answer each. Blocks.
    fn store(&self, records: &[(&str, Bytes)]) -> Vec<Result<(), JournalError>>;

    /// Whether the records of a session shall be replaced by one.
    fn is_whole_due(&self, name: &str) -> bool;

    /// Replaces them; none of them is left where there is no session any more. Blocks.
    fn replace(&self, name: &str, whole: &Bytes);
}

/// The changes of one record.
#[derive(Clone, PartialEq, Message)]
struct Entries {
    #[prost(message, repeated, tag = "1")]
    entries: Vec<Entry>,
}

/// A [`Change`] of a session.
#[derive(Clone, PartialEq, Message)]
struct Entry {
    /// Sequence, event or number.
    #[prost(int64, tag = "1")]
    number: i64,
    #[prost(oneof = "Kind", tags = "2, 3, 4, 5, 6, 7, 8, 9, 10, 11")]
    kind: Option<Kind>,
}

#[derive(Clone, PartialEq, Oneof)]
enum Kind {
    #[prost(message, tag = "2")]
    Session(StoredSession),
    #[prost(message, tag = "3")]
    Update(StoredUpdate),
    #[prost(bool, tag = "4")]
    Withdraw(bool),
    #[prost(message, tag = "5")]
    Result(ResultEntry),
    #[prost(message, tag = "6")]
    Checkpoint(StoredCheckpoint),
    #[prost(message, tag = "7")]
    Save(StoredSave),
    #[prost(bool, tag = "8")]
    DropSaves(bool),
    #[prost(bool, tag = "9")]
    DropResults(bool),
    #[prost(bool, tag = "10")]
    DropFields(bool),
    #[prost(bool, tag = "11")]
    Delete(bool),
}

#[derive(Clone, PartialEq, Message)]
struct ResultEntry {
    #[prost(message, required, tag = "1")]
    result: StoredResult,
    #[prost(message, required, tag = "2")]
    fields: StoredFields,
}

fn entry(change: &Change) -> Option<Entry> {
    let (number, kind) = match change {
        Change::Session(session) => (0, Kind::Session(session.clone())),
        Change::Update(sequence, update) => (*sequence, Kind::Update(update.clone())),
        Change::Withdraw(from) => (*from, Kind::Withdraw(true)),
        Change::Result(event, result, fields) => {
            let (result, fields) = (result.clone(), fields.clone());
            (*event, Kind::Result(ResultEntry { result, fields }))
        }
        Change::Checkpoint(checkpoint) => (0, Kind::Checkpoint(checkpoint.clone())),
        Change::Save(number, save) => (*number, Kind::Save(save.clone())),
        Change::DropSaves(before) => (*before, Kind::DropSaves(true)),
        Change::DropResults(before) => (*before, Kind::DropResults(true)),
        Change::DropFields(before) => (*before, Kind::DropFields(true)),
        Change::Delete => (0, Kind::Delete(true)),
        Change::Begin
        | Change::Mesh(..)
        | Change::DropMesh(_)
        | Change::Surface(..)
        | Change::DropSurface(_)
        | Change::State(..)
        | Change::DropState(_) => return None,
    };
    let kind = Some(kind);
    Some(Entry { number, kind })
}

fn change(entry: Entry) -> Option<Change> {
    let number = entry.number;
    Some(match entry.kind? {
        Kind::Session(session) => Change::Session(session),
        Kind::Update(update) => Change::Update(number, update),
        Kind::Withdraw(_) => Change::Withdraw(number),
        Kind::Result(entry) => Change::Result(number, entry.result, entry.fields),
        Kind::Checkpoint(checkpoint) => Change::Checkpoint(checkpoint),
        Kind::Save(save) => Change::Save(number, save),
        Kind::DropSaves(_) => Change::DropSaves(number),
        Kind::DropResults(_) => Change::DropResults(number),
        Kind::DropFields(_) => Change::DropFields(number),
        Kind::Delete(_) => Change::Delete,
    })
}

/// Whether a change is of this folder alone: nobody else has it.
pub(super) fn is_own(change: &Change) -> bool {
    match change {
        Change::Mesh(..)
        | Change::DropMesh(_)
        | Change::Surface(..)
        | Change::DropSurface(_)
        | Change::State(..)
        | Change::DropState(_) => true,
        Change::Begin
        | Change::Session(_)
        | Change::Update(..)
        | Change::Withdraw(_)
        | Change::Result(..)
        | Change::Checkpoint(_)
        | Change::Save(..)
        | Change::DropSaves(_)
        | Change::DropResults(_)
        | Change::DropFields(_)
        | Change::Delete => false,
    }
}

/// Changes as a record; empty where none is of a session.
pub(super) fn encoded<'a>(changes: impl Iterator<Item = &'a Change>) -> Bytes {
    let entries = changes.filter_map(entry).collect();
    Entries { entries }.encode_to_vec().into()
}

fn decoded(name: &str, record: &Bytes) -> Result<Vec<Change>, JournalError> {
    let damaged = || JournalError::Damaged(format!("a record of {name} cannot be read"));
    let entries = Entries::decode(record.clone()).map_err(|_| damaged())?;
    let changes = entries
        .entries
        .into_iter()
        .map(|entry| change(entry).ok_or_else(damaged));
    changes.collect()
}

/// All of a session as a record that needs no other.
pub(super) fn whole(stored: Option<Stored>) -> Bytes {
    let Some(stored) = stored else {
        return Bytes::new();
    };
    let mut changes = vec![Change::Delete, Change::Session(stored.session)];
    changes.extend(stored.checkpoint.map(Change::Checkpoint));
    changes.extend(
        stored
            .saves
            .into_iter()
            .map(|(number, save)| Change::Save(number, save)),
    );
    let results = stored.results.into_iter();
    changes.extend(results.map(|(event, result, fields)| Change::Result(event, result, fields)));
    let updates = stored.updates.into_iter();
    changes.extend(updates.map(|(sequence, update)| Change::Update(sequence, update)));
    encoded(changes.iter())
}

impl Journal {
    /// From now on changes of sessions go through the fence first.
    pub(crate) fn fence(&self, fence: Arc<dyn Fence>) {
        self.writer.fence(fence);
    }

    /// Forgets every session.
    pub(crate) async fn forget_sessions(&self) -> Result<(), JournalError> {
        for name in self.database.with(database::names)? {
            self.store(&name, vec![Change::Delete]).await?;
        }
        Ok(())
    }

    /// Takes over the records of a session; whether there is one.
    pub(crate) async fn adopt(&self, name: &str, records: &[Bytes]) -> Result<bool, JournalError> {
        let mut changes = vec![Change::Begin, Change::Delete];
        for record in records {
            changes.extend(decoded(name, record)?);
        }
        self.store_adopted(name, changes).await?;
        Ok(self.listed(name).is_some())
    }
}
