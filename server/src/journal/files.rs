//! Files of the data folder, named by the digests of what they hold.
//!
//! A file is written beside its place, reaches the disk, and then takes its name: under
//! a name there is all of it or nothing.

use std::fs::{self, File};
use std::io::{self, BufWriter, Read as _, Write};
use std::os::unix::fs::{DirBuilderExt as _, OpenOptionsExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use super::error::JournalError;

/// What is made may be used by its owner alone.
const OWN_FOLDER: u32 = 0o700;
const OWN_FILE: u32 = 0o600;
/// Everything that others may do.
const OTHERS: u32 = 0o077;
const STICKY: u32 = 0o1000;

/// A file that is on the disk and has no name yet; gone unless it gets one.
pub(crate) struct Part(PathBuf);

impl Part {
    /// Writes a file without a name into `folder`.
    pub(super) fn write(
        folder: &Path,
        fill: impl FnOnce(&mut dyn FnMut(&[u8]) -> io::Result<()>) -> io::Result<()>,
    ) -> Result<Self, JournalError> {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let part = Self(folder.join(format!("{number}.part")));
        match part.fill(fill) {
            Ok(()) => Ok(part),
            Err(error) => Err(unwritable(&part.0, &error)),
        }
    }

    fn fill(
        &self,
        fill: impl FnOnce(&mut dyn FnMut(&[u8]) -> io::Result<()>) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut file = BufWriter::new(create(&self.0)?);
        fill(&mut |bytes| {
            fail::fail_point!("file-write", |_| Err(io::Error::other("failpoint")));
            file.write_all(bytes)
        })?;
        let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
        fail::fail_point!("file-sync", |_| Err(io::Error::other("failpoint")));
        file.sync_all()
    }

    /// Gives it its name, on the disk too.
    pub(super) fn keep(self, path: &Path) -> Result<(), JournalError> {
        let named = self.name(path);
        named.map_err(|error| unwritable(path, &error))
    }

    fn name(&self, path: &Path) -> io::Result<()> {
        fail::fail_point!("file-rename", |_| Err(io::Error::other("failpoint")));
        fs::rename(&self.0, path)?;
        fail::fail_point!("folder-sync", |_| Err(io::Error::other("failpoint")));
        sync_folder(path)
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        // It is not there any more when it has a name.
        let _named = fs::remove_file(&self.0);
    }
}

fn unwritable(path: &Path, error: &io::Error) -> JournalError {
    JournalError::Unwritable(format!("{}: {error}", path.display()))
}

/// A new file that only its owner reads.
fn create(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    options.write(true).create(true).truncate(true);
    options.mode(OWN_FILE).open(path)
}

/// Writes a file whole, in its place when the disk has it.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), JournalError> {
    let folder = path.parent().unwrap_or(path);
    Part::write(folder, |put| put(bytes))?.keep(path)
}

/// The name of a file or folder reaches the disk with the folder that it lies in.
pub(crate) fn sync_folder(path: &Path) -> io::Result<()> {
    match path.parent() {
        Some(folder) if folder.as_os_str().is_empty() => sync(Path::new(".")),
        Some(folder) => sync(folder),
        None => Ok(()),
    }
}

/// Bytes that a copy reads at one time.
const COPIED: usize = 1 << 20;

/// Copies a file, onto the disk: byte by byte, so that the two share no block, as file systems
/// let them that copy by reference.
pub(crate) fn copy_bytes(from: &Path, to: &Path) -> io::Result<()> {
    let (mut source, mut target) = (File::open(from)?, create(to)?);
    let mut bytes = vec![0; COPIED];
    loop {
        let read = source.read(&mut bytes)?;
        let Some(read) = bytes.get(..read).filter(|read| !read.is_empty()) else {
            break;
        };
        target.write_all(read)?;
    }
    target.sync_all()
}

/// Waits until the disk has a file, or the names in a folder.
pub(super) fn sync(path: &Path) -> io::Result<()> {
    File::open(path)?.sync_all()
}

/// All of a file; none where there is no such file.
pub(super) fn read(path: &Path) -> Result<Option<Vec<u8>>, JournalError> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(JournalError::at(path, &error)),
    }
}

/// Removes a file, if it is there.
pub(super) fn remove(path: &Path) -> Result<(), JournalError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(JournalError::at(path, &error))
        }
        Ok(()) | Err(_) => Ok(()),
    }
}

/// Makes a folder that only its owner reads, and those above it, on the disk too; one that is
/// there already is closed to others.
pub(crate) fn make_folder(path: &Path) -> Result<(), JournalError> {
    made(path).map_err(|error| JournalError::at(path, &error))
}

fn made(path: &Path) -> io::Result<()> {
    let named = path.ancestors().filter(|one| !one.as_os_str().is_empty());
    let missing: Vec<&Path> = named.take_while(|one| !one.exists()).collect();
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true).mode(OWN_FOLDER).create(path)?;
    close(path, OWN_FOLDER)?;
    missing.into_iter().try_for_each(sync_folder)
}

/// Closes a file to everybody but its owner.
pub(crate) fn close_file(path: &Path) -> io::Result<()> {
    close(path, OWN_FILE)
}

fn close(path: &Path, mode: u32) -> io::Result<()> {
    let found = fs::metadata(path)?.permissions().mode();
    // A folder for temporary files of everybody is none of ours, whoever owns it.
    let is_shared = found & STICKY != 0;
    if found & OTHERS == 0 || is_shared {
        return Ok(());
    }
    match fs::set_permissions(path, fs::Permissions::from_mode(mode)) {
        // Of another owner, or on a file system that knows no modes: whoever made it so may.
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied => {
            let path = path.display().to_string();
            tracing::warn!(path, "is open to others, and this user cannot close it");
            Ok(())
        }
        outcome => outcome,
    }
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
