//! Files of the data folder, named by the digests of what they hold.
//!
//! A file is written beside its place, reaches the disk, and then takes its name: under
//! a name there is all of it or nothing.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::error::JournalError;

/// Writes a file whole, in its place when the disk has it.
pub(super) fn write(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), JournalError> {
    let wrong = |error: io::Error| JournalError::Unwritable(format!("{}: {error}", path.display()));
    let beside = path.with_extension("part");
    let written = write_beside(&beside, fill).and_then(|()| {
        fail::fail_point!("file-rename", |_| Err(io::Error::other("failpoint")));
        fs::rename(&beside, path)?;
        sync_folder(path)
    });
    if written.is_err() {
        // Nothing of use is in it, and it may not exist.
        let _left = fs::remove_file(&beside);
    }
    written.map_err(wrong)
}

fn write_beside(
    beside: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(beside)?);
    fill(&mut file)?;
    fail::fail_point!("file-sync", |_| Err(io::Error::other("failpoint")));
    let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.sync_all()
}

/// The name of a file reaches the disk with its folder.
fn sync_folder(path: &Path) -> io::Result<()> {
    match path.parent() {
        Some(folder) => File::open(folder)?.sync_all(),
        None => Ok(()),
    }
}

/// All of a file; none where there is no such file.
pub(super) fn read(path: &Path) -> Result<Option<Vec<u8>>, JournalError> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(JournalError::at(path, &error)),
    }
}

/// Makes a folder that only its owner reads, and those above it.
pub(super) fn make_folder(path: &Path) -> Result<(), JournalError> {
    use std::os::unix::fs::DirBuilderExt;
    let mut builder = fs::DirBuilder::new();
    let made = builder.recursive(true).mode(0o700).create(path);
    made.map_err(|error| JournalError::at(path, &error))
}

/// Drops what a writer that was killed has left.
pub(super) fn drop_parts(folder: &Path) -> Result<(), JournalError> {
    let wrong = |error: io::Error| JournalError::at(folder, &error);
    for entry in fs::read_dir(folder).map_err(wrong)? {
        let path: PathBuf = entry.map_err(wrong)?.path();
        if path.extension().is_some_and(|end| end == "part") {
            fs::remove_file(&path).map_err(wrong)?;
        }
    }
    Ok(())
}
