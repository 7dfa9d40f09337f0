//! Small files: read within a limit, written whole.

use std::fs::{self, File, OpenOptions};
use std::io::{Read as _, Write as _};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::Path;

use super::AccessError;

/// The text of a file of at most `limit` bytes.
pub(super) fn read(path: &Path, limit: u64) -> Result<String, AccessError> {
    let wrong = |error| AccessError::new(path, error);
    let mut text = String::new();
    let file = File::open(path).map_err(wrong)?;
    let read = file.take(limit + 1).read_to_string(&mut text);
    if read.map_err(wrong)? as u64 > limit {
        let why = format!("has more than {limit} bytes");
        return Err(AccessError::new(path, why));
    }
    Ok(text)
}

/// Writes beside the place and renames, so that a reader sees the old file or the new one.
pub(super) fn write_private(path: &Path, bytes: &[u8]) -> Result<(), AccessError> {
    let wrong = |error| AccessError::new(path, error);
    let mut beside = path.as_os_str().to_owned();
    beside.push(format!(".{}.part", std::process::id()));
    let beside = Path::new(&beside);
    let written = OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(0o600)
        .open(beside)
        .and_then(|mut file| {
            file.write_all(bytes)?;
            file.sync_all()
        })
        .and_then(|()| fs::rename(beside, path));
    written.map_err(|error| {
        // Nothing is there when it could not be opened.
        let _gone = fs::remove_file(beside);
        wrong(error)
    })
}

/// What changes when somebody changes a file or puts another in its place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Stamp(Option<(u64, u64, i64, i64)>);

impl Stamp {
    pub(super) fn of(path: &Path) -> Self {
        let found = fs::metadata(path).ok();
        Self(found.map(|one| (one.ino(), one.size(), one.mtime(), one.mtime_nsec())))
    }
}
