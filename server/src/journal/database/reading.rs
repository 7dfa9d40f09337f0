//! How the tables are read.

use redb::{Database, ReadTransaction, ReadableDatabase, ReadableTable, TableDefinition};

use super::super::error::JournalError;
use super::super::record::{
    StoredCheckpoint, StoredFields, StoredMesh, StoredResult, StoredSave, StoredSession,
    StoredState, StoredSurface, StoredUpdate, opened,
};
use super::{CHECKPOINTS, FIELDS, MESHES, RESULTS, SAVES, SESSIONS, STATES, SURFACES, UPDATES};

/// A session with all that is stored of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Stored {
    pub(crate) session: StoredSession,
    pub(crate) updates: Vec<(i64, StoredUpdate)>,
    pub(crate) results: Vec<(i64, StoredResult, StoredFields)>,
    pub(crate) checkpoint: Option<StoredCheckpoint>,
    pub(crate) saves: Vec<(i64, StoredSave)>,
}

/// What a list tells of a stored session.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Listed {
    pub(crate) session: StoredSession,
    /// Largest sequence accepted.
    pub(crate) accepted: i64,
    /// Largest sequence finished.
    pub(crate) finished: i64,
    /// Smallest sequence with a result.
    pub(crate) first: i64,
}

/// An entry of a table: session and number, message.
type Row<'a> = (
    redb::AccessGuard<'a, (&'static str, i64)>,
    redb::AccessGuard<'a, &'static [u8]>,
);

/// Every stored session, in order of the names.
pub(in crate::journal) fn list(database: &Database) -> Result<Vec<(String, Listed)>, JournalError> {
    let read = database.begin_read()?;
    let mut found = Vec::new();
    for entry in read.open_table(SESSIONS)?.iter()? {
        let (name, session) = entry?;
        let name = name.value();
        // One that is damaged says so when it is called; the others serve.
        let session = opened(session.value(), name);
        let listed = match session.and_then(|session| listed(&read, name, session)) {
            Err(JournalError::Damaged(why)) => {
                tracing::error!(name, why, "a session is damaged");
                Listed::default()
            }
            outcome => outcome?,
        };
        found.push((name.to_owned(), listed));
    }
    Ok(found)
}

/// One stored session as a list tells it.
pub(in crate::journal) fn list_one(
    database: &Database,
    name: &str,
) -> Result<Option<Listed>, JournalError> {
    let read = database.begin_read()?;
    let Some(session) = read.open_table(SESSIONS)?.get(name)? else {
        return Ok(None);
    };
    let session = opened(session.value(), name)?;
    listed(&read, name, session).map(Some)
}

/// Names of the sessions, readable or not.
pub(in crate::journal) fn names(database: &Database) -> Result<Vec<String>, JournalError> {
    let read = database.begin_read()?;
    let table = read.open_table(SESSIONS)?;
    let all = table.iter()?.map(|entry| Ok(entry?.0.value().to_owned()));
    all.collect()
}

fn listed(
    read: &ReadTransaction,
    name: &str,
    session: StoredSession,
) -> Result<Listed, JournalError> {
    let all = (name, i64::MIN)..=(name, i64::MAX);
    let updates = read.open_table(UPDATES)?;
    let results = read.open_table(RESULTS)?;
    let accepted = updates.range(all.clone())?.next_back().transpose()?;
    let accepted = accepted.map_or(0, |(key, _)| key.value().1);
    let mut ends = results.range(all)?;
    let result = |entry: Option<Result<Row<'_>, redb::StorageError>>| {
        let entry = entry.transpose()?;
        let stored = entry.map(|(_, value)| opened::<StoredResult>(value.value(), name));
        stored.transpose()
    };
    let newest = result(ends.next_back())?;
    let oldest = result(ends.next())?.or_else(|| newest.clone());
    let finished = newest.map_or(0, |one| one.sequence - i64::from(!one.last));
    Ok(Listed {
        session,
        accepted: accepted.max(finished),
        finished,
        first: oldest.map_or(0, |one| one.sequence),
    })
}

/// All of one session; none where there is no such session.
pub(in crate::journal) fn load(
    database: &Database,
    name: &str,
) -> Result<Option<Stored>, JournalError> {
    let read = database.begin_read()?;
    let Some(session) = read.open_table(SESSIONS)?.get(name)? else {
        return Ok(None);
    };
    let session = opened(session.value(), name)?;
    let all = || (name, i64::MIN)..=(name, i64::MAX);
    let mut updates = Vec::new();
    for entry in read.open_table(UPDATES)?.range(all())? {
        let (key, update) = entry?;
        updates.push((key.value().1, opened(update.value(), name)?));
    }
    let fields = read.open_table(FIELDS)?;
    let mut results = Vec::new();
    for entry in read.open_table(RESULTS)?.range(all())? {
        let (key, result) = entry?;
        let event = key.value().1;
        let own = fields.get((name, event))?;
        let own = own.map(|fields| opened(fields.value(), name)).transpose()?;
        results.push((
            event,
            opened(result.value(), name)?,
            own.unwrap_or_default(),
        ));
    }
    let mut saves = Vec::new();
    for entry in read.open_table(SAVES)?.range(all())? {
        let (key, save) = entry?;
        saves.push((key.value().1, opened(save.value(), name)?));
    }
    let checkpoint = read.open_table(CHECKPOINTS)?.get(name)?;
    let checkpoint = checkpoint.map(|bytes| opened(bytes.value(), name));
    Ok(Some(Stored {
        session,
        updates,
        results,
        checkpoint: checkpoint.transpose()?,
        saves,
    }))
}

/// One mesh.
pub(in crate::journal) fn mesh(
    database: &Database,
    name: &str,
) -> Result<Option<StoredMesh>, JournalError> {
    one(database, MESHES, name)
}

/// The meshes by name.
pub(in crate::journal) fn meshes(
    database: &Database,
) -> Result<Vec<(String, StoredMesh)>, JournalError> {
    all(database, MESHES)
}

/// One surface of a tool.
pub(in crate::journal) fn surface(
    database: &Database,
    name: &str,
) -> Result<Option<StoredSurface>, JournalError> {
    one(database, SURFACES, name)
}

/// The surfaces of tools by name; none in a folder of a build that stored none.
pub(in crate::journal) fn surfaces(
    database: &Database,
) -> Result<Vec<(String, StoredSurface)>, JournalError> {
    all(database, SURFACES)
}

/// The imported states by digest.
pub(in crate::journal) fn states(
    database: &Database,
) -> Result<Vec<(String, StoredState)>, JournalError> {
    all(database, STATES)
}

fn one<M: prost::Message + Default>(
    database: &Database,
    table: TableDefinition<'_, &str, &'static [u8]>,
    name: &str,
) -> Result<Option<M>, JournalError> {
    let read = database.begin_read()?;
    let found = read.open_table(table)?.get(name)?;
    found.map(|bytes| opened(bytes.value(), name)).transpose()
}

fn all<M: prost::Message + Default>(
    database: &Database,
    table: TableDefinition<'_, &str, &'static [u8]>,
) -> Result<Vec<(String, M)>, JournalError> {
    let read = database.begin_read()?;
    let table = match read.open_table(table) {
        // Of a build that stored nothing of the kind.
        Err(redb::TableError::TableDoesNotExist(_)) => return Ok(Vec::new()),
        table => table?,
    };
    let mut found = Vec::new();
    for entry in table.iter()? {
        let (name, value) = entry?;
        let message = opened(value.value(), name.value())?;
        found.push((name.value().to_owned(), message));
    }
    Ok(found)
}
