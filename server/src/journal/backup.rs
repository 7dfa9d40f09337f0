//! A copy of a data folder while a server uses it, which is a data folder again.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use redb::{Database, ReadableDatabase, ReadableTable, TableDefinition};

use super::PARTS;
use super::database;
use super::error::JournalError;
use super::files;
use super::layout::{DATABASE_FILE, FORMAT_FILE};

/// How the files of a backup come about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Copying {
    /// By their bytes: what becomes of the folder does not touch the backup.
    #[default]
    Bytes,
    /// By a second name, where the file system allows that: at once and without room, and what
    /// spoils a file of the folder spoils it in the backup.
    Links,
}

/// Copies the folder into `target`, which must not exist: all sessions as they are at
/// one moment, and the files that they need.
pub(super) fn copy(
    source: &Database,
    (folder, target): (&Path, &Path),
    copying: Copying,
) -> Result<(), JournalError> {
    let beside = target.with_extension("part");
    if target.exists() {
        return Err(JournalError::at(target, &"exists already"));
    }
    remove(&beside)?;
    let made = make(source, (folder, &beside), copying).and_then(|()| {
        let moved = fs::rename(&beside, target).and_then(|()| files::sync_folder(target));
        moved.map_err(|error| JournalError::at(target, &error))
    });
    if made.is_err() {
        remove(&beside)?;
    }
    made
}

fn make(
    source: &Database,
    (folder, target): (&Path, &Path),
    copying: Copying,
) -> Result<(), JournalError> {
    for part in PARTS {
        files::make_folder(&target.join(part))?;
    }
    // A file that goes or comes meanwhile is in one of the two.
    copy_files(folder, target, copying)?;
    copy_database(source, &target.join(DATABASE_FILE))?;
    copy_files(folder, target, copying)?;
    let format = folder.join(FORMAT_FILE);
    files::copy_bytes(&format, &target.join(FORMAT_FILE))
        .map_err(|error| JournalError::at(&format, &error))?;
    let folders = PARTS.map(|part| target.join(part));
    let mut all = folders.iter().map(PathBuf::as_path).chain([target]);
    all.try_for_each(files::sync)
        .map_err(|error| JournalError::at(target, &error))
}

/// Files never change: one that is there is whole, for it gets its name when it is.
fn copy_files(folder: &Path, target: &Path, copying: Copying) -> Result<(), JournalError> {
    for part in PARTS {
        let from = folder.join(part);
        let wrong = |error: io::Error| JournalError::at(&from, &error);
        let entries = match fs::read_dir(&from) {
            // Of a build that stored nothing of the kind.
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            entries => entries.map_err(wrong)?,
        };
        for entry in entries {
            let entry = entry.map_err(wrong)?;
            let to = target.join(part).join(entry.file_name());
            let is_part = entry.path().extension().is_some_and(|end| end == "part");
            if is_part || to.exists() {
                continue;
            }
            let is_linked = copying == Copying::Links && fs::hard_link(entry.path(), &to).is_ok();
            if !is_linked {
                match copy_whole(&entry.path(), &to) {
                    // It has been dropped since.
                    Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                    outcome => outcome.map_err(wrong)?,
                }
            }
        }
    }
    Ok(())
}

/// Copies a file beside its place first.
fn copy_whole(from: &Path, to: &Path) -> io::Result<()> {
    let beside = to.with_extension("part");
    files::copy_bytes(from, &beside)?;
    fs::rename(&beside, to)
}

fn copy_database(source: &Database, path: &Path) -> Result<(), JournalError> {
    let read = source.begin_read()?;
    database::create(path)?;
    let target = database::open(path)?;
    let write = target.begin_write()?;
    for table in database::BY_NAME {
        copy_table(&read, &write, table)?;
    }
    for table in database::BY_PLACE {
        copy_table(&read, &write, table)?;
    }
    write.commit()?;
    Ok(())
}

fn copy_table<K: redb::Key + 'static>(
    read: &redb::ReadTransaction,
    write: &redb::WriteTransaction,
    table: TableDefinition<'_, K, &'static [u8]>,
) -> Result<(), JournalError> {
    let mut copy = write.open_table(table)?;
    for entry in read.open_table(table)?.iter()? {
        let (key, value) = entry?;
        copy.insert(key.value(), value.value())?;
    }
    Ok(())
}

/// Removes what an earlier copy has left.
fn remove(folder: &Path) -> Result<(), JournalError> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(JournalError::at(folder, &error))
        }
        Ok(()) | Err(_) => Ok(()),
    }
}
