//! The tables, what is written into them and how they are read.
//!
//! A commit returns when the disk has it, or before that where somebody else has what it writes
//! ([`Durability::None`]). Values are sealed; keys begin with the name of their session, so that
//! all of one session lies together.

use std::path::Path;

use redb::{Database, Durability, TableDefinition, WriteTransaction};

mod reading;

use super::error::JournalError;
use super::record::{
    StoredCheckpoint, StoredFields, StoredMesh, StoredResult, StoredSave, StoredSession,
    StoredState, StoredSurface, StoredUpdate, sealed,
};
use super::{files, guarded};
pub(crate) use reading::{Listed, Stored};
pub(super) use reading::{list, list_one, load, mesh, meshes, names, states, surface, surfaces};

const META: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("meta");
const SESSIONS: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("sessions");
const UPDATES: TableDefinition<'_, (&str, i64), &[u8]> = TableDefinition::new("updates");
pub(super) const RESULTS: TableDefinition<'_, (&str, i64), &[u8]> = TableDefinition::new("results");
const FIELDS: TableDefinition<'_, (&str, i64), &[u8]> = TableDefinition::new("fields");
pub(super) const CHECKPOINTS: TableDefinition<'_, &str, &[u8]> =
    TableDefinition::new("checkpoints");
const SAVES: TableDefinition<'_, (&str, i64), &[u8]> = TableDefinition::new("saves");
const MESHES: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("meshes");
const STATES: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("states");
const SURFACES: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("surfaces");

/// The tables whose keys are names.
pub(super) const BY_NAME: [TableDefinition<'_, &str, &[u8]>; 6] =
    [META, SESSIONS, CHECKPOINTS, MESHES, STATES, SURFACES];
/// The tables whose keys are a session and a number.
pub(super) const BY_PLACE: [TableDefinition<'_, (&str, i64), &[u8]>; 4] =
    [UPDATES, RESULTS, FIELDS, SAVES];

/// Pages that the database keeps in memory.
const CACHE_BYTES: usize = 16 << 20;

/// One thing to write.
#[derive(Clone, Debug)]
pub(crate) enum Change {
    /// Whoever writes this knows what the disk has of the session: changes that failed
    /// before no longer hold up later ones.
    Begin,
    /// A session is made.
    Session(StoredSession),
    /// An update is accepted.
    Update(i64, StoredUpdate),
    /// Updates from this sequence on have lost their place.
    Withdraw(i64),
    /// A result, by its event.
    Result(i64, StoredResult, StoredFields),
    /// A state to go on from; updates that lead to it are of no more use.
    Checkpoint(StoredCheckpoint),
    /// A state that a client may go back to, by its number.
    Save(i64, StoredSave),
    /// Saved states before this one are dropped.
    DropSaves(i64),
    /// Results before this event are dropped.
    DropResults(i64),
    /// Fields of results before this event are dropped.
    DropFields(i64),
    /// The session is over.
    Delete,
    /// A mesh, by its name.
    Mesh(String, StoredMesh),
    /// A mesh is dropped.
    DropMesh(String),
    /// A surface of a tool, by its name.
    Surface(String, StoredSurface),
    /// A surface is dropped.
    DropSurface(String),
    /// An imported state, by its digest.
    State(String, StoredState),
    /// A state is dropped.
    DropState(String),
}

/// Opens the database, which has to be there.
pub(super) fn open(path: &Path) -> Result<Database, JournalError> {
    let opened = opened_by(path, || builder().open(path))?;
    files::close_file(path).map_err(|error| JournalError::at(path, &error))?;
    Ok(opened)
}

/// Makes a database with every table: beside its place, where there is all of it or nothing.
pub(super) fn create(path: &Path) -> Result<(), JournalError> {
    let beside = path.with_extension("part");
    let wrong = |error: std::io::Error| JournalError::at(path, &error);
    files::remove(&beside)?;
    let made = opened_by(&beside, || builder().create(&beside))?;
    make_tables(&made)?;
    drop(made);
    files::close_file(&beside).map_err(wrong)?;
    std::fs::File::open(&beside)
        .and_then(|file| file.sync_all())
        .map_err(wrong)?;
    std::fs::rename(&beside, path)
        .and_then(|()| files::sync_folder(path))
        .map_err(wrong)
}

fn builder() -> redb::Builder {
    let mut builder = Database::builder();
    builder.set_cache_size(CACHE_BYTES);
    builder
}

fn opened_by(
    path: &Path,
    open: impl FnOnce() -> Result<Database, redb::DatabaseError>,
) -> Result<Database, JournalError> {
    let at = path.display().to_string();
    match guarded(|| Ok(open()))? {
        Ok(database) => Ok(database),
        Err(redb::DatabaseError::DatabaseAlreadyOpen) => Err(JournalError::InUse(at)),
        Err(redb::DatabaseError::Storage(redb::StorageError::Io(why))) => {
            Err(JournalError::at(path, &why))
        }
        Err(error) => Err(JournalError::Damaged(format!("{at}: {error}"))),
    }
}

/// Makes every table, so that readers find them.
pub(super) fn make_tables(database: &Database) -> Result<(), JournalError> {
    let write = database.begin_write()?;
    Tables::open(&write)?;
    write.commit()?;
    Ok(())
}

/// Whether the database at `path` has neither sessions nor meshes nor surfaces.
pub(super) fn is_unused(path: &Path) -> Result<bool, JournalError> {
    let open = open(path)?;
    guarded(|| {
        make_tables(&open)?;
        let has_uploads = !meshes(&open)?.is_empty() || !surfaces(&open)?.is_empty();
        Ok(names(&open)?.is_empty() && !has_uploads)
    })
}

/// The tables of one transaction.
struct Tables<'a> {
    sessions: redb::Table<'a, &'static str, &'static [u8]>,
    updates: redb::Table<'a, (&'static str, i64), &'static [u8]>,
    results: redb::Table<'a, (&'static str, i64), &'static [u8]>,
    fields: redb::Table<'a, (&'static str, i64), &'static [u8]>,
    checkpoints: redb::Table<'a, &'static str, &'static [u8]>,
    saves: redb::Table<'a, (&'static str, i64), &'static [u8]>,
    meshes: redb::Table<'a, &'static str, &'static [u8]>,
    states: redb::Table<'a, &'static str, &'static [u8]>,
    surfaces: redb::Table<'a, &'static str, &'static [u8]>,
}

impl<'a> Tables<'a> {
    fn open(write: &'a WriteTransaction) -> Result<Self, JournalError> {
        write.open_table(META)?;
        Ok(Self {
            sessions: write.open_table(SESSIONS)?,
            updates: write.open_table(UPDATES)?,
            results: write.open_table(RESULTS)?,
            fields: write.open_table(FIELDS)?,
            checkpoints: write.open_table(CHECKPOINTS)?,
            saves: write.open_table(SAVES)?,
            meshes: write.open_table(MESHES)?,
            states: write.open_table(STATES)?,
            surfaces: write.open_table(SURFACES)?,
        })
    }

    /// Writes a change of the session `name`; the bytes that it takes.
    fn apply(&mut self, name: &str, change: &Change) -> Result<usize, JournalError> {
        let mut written = 0;
        let mut seal = |bytes: Vec<u8>| {
            written += bytes.len();
            bytes
        };
        match change {
            Change::Begin => {}
            Change::Session(session) => {
                let bytes = seal(sealed(session));
                self.sessions.insert(name, bytes.as_slice())?;
            }
            Change::Update(sequence, update) => {
                let bytes = seal(sealed(update));
                self.updates.insert((name, *sequence), bytes.as_slice())?;
            }
            Change::Withdraw(from) => drop_keys(&mut self.updates, name, *from, i64::MAX)?,
            Change::Result(event, result, fields) => {
                let bytes = seal(sealed(result));
                self.results.insert((name, *event), bytes.as_slice())?;
                if !fields.fields.is_empty() {
                    let bytes = seal(sealed(fields));
                    self.fields.insert((name, *event), bytes.as_slice())?;
                }
            }
            Change::Checkpoint(checkpoint) => {
                let bytes = seal(sealed(checkpoint));
                self.checkpoints.insert(name, bytes.as_slice())?;
                let needed = checkpoint.sequence + i64::from(checkpoint.done == 0);
                drop_keys(&mut self.updates, name, i64::MIN, needed - 1)?;
            }
            Change::Save(number, save) => {
                let bytes = seal(sealed(save));
                self.saves.insert((name, *number), bytes.as_slice())?;
            }
            Change::DropSaves(before) => {
                drop_keys(&mut self.saves, name, i64::MIN, before - 1)?;
            }
            Change::DropResults(before) => {
                drop_keys(&mut self.results, name, i64::MIN, before - 1)?;
                drop_keys(&mut self.fields, name, i64::MIN, before - 1)?;
            }
            Change::DropFields(before) => {
                drop_keys(&mut self.fields, name, i64::MIN, before - 1)?;
            }
            Change::Delete => self.delete(name)?,
            Change::Mesh(mesh, stored) => {
                let bytes = seal(sealed(stored));
                self.meshes.insert(mesh.as_str(), bytes.as_slice())?;
            }
            Change::DropMesh(mesh) => {
                self.meshes.remove(mesh.as_str())?;
            }
            Change::Surface(surface, stored) => {
                let bytes = seal(sealed(stored));
                self.surfaces.insert(surface.as_str(), bytes.as_slice())?;
            }
            Change::DropSurface(surface) => {
                self.surfaces.remove(surface.as_str())?;
            }
            Change::State(digest, stored) => {
                let bytes = seal(sealed(stored));
                self.states.insert(digest.as_str(), bytes.as_slice())?;
            }
            Change::DropState(digest) => {
                self.states.remove(digest.as_str())?;
            }
        }
        Ok(written)
    }

    fn delete(&mut self, name: &str) -> Result<(), JournalError> {
        self.sessions.remove(name)?;
        self.checkpoints.remove(name)?;
        drop_keys(&mut self.updates, name, i64::MIN, i64::MAX)?;
        drop_keys(&mut self.results, name, i64::MIN, i64::MAX)?;
        drop_keys(&mut self.saves, name, i64::MIN, i64::MAX)?;
        drop_keys(&mut self.fields, name, i64::MIN, i64::MAX)
    }
}

/// Drops the entries of a session from `first` to `last`.
fn drop_keys(
    table: &mut redb::Table<'_, (&'static str, i64), &'static [u8]>,
    name: &str,
    first: i64,
    last: i64,
) -> Result<(), JournalError> {
    if first <= last {
        table.retain_in((name, first)..=(name, last), |_, _| false)?;
    }
    Ok(())
}

/// Writes all changes at once, and returns when they are as durable as is asked; the bytes
/// written.
pub(super) fn commit<'a>(
    database: &Database,
    changes: impl Iterator<Item = (&'a str, &'a Change)>,
    durability: Durability,
) -> Result<usize, JournalError> {
    let mut write = database.begin_write()?;
    let refused = |error: redb::SetDurabilityError| JournalError::Unwritable(error.to_string());
    write.set_durability(durability).map_err(refused)?;
    let mut bytes = 0;
    {
        let mut tables = Tables::open(&write)?;
        for (name, change) in changes {
            bytes += tables.apply(name, change)?;
        }
    }
    write.commit()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests;
