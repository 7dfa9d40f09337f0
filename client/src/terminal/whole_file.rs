//! Files that are whole or not there: written under another name beside, then renamed.
//!
//! What stands under the name before, a symbolic link to somewhere else too, is
//! replaced and never written through. A process that is killed leaves at most a
//! hidden file that ends in `.part`.

use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Write as _};
use std::path::{Path, PathBuf};

/// Writes a file.
///
/// # Errors
/// Of the system; what stood under the name is then as before.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let (beside, mut file) = open_beside(path)?;
    let written = file
        .write_all(bytes)
        .and_then(|()| std::fs::rename(&beside, path));
    if written.is_err() {
        // The failure that is told is the first one.
        let _gone = std::fs::remove_file(&beside);
    }
    written
}

/// A new, empty file under that name, for lines that come one after another.
///
/// # Errors
/// Of the system.
pub(crate) fn create(path: &Path) -> io::Result<File> {
    let (beside, file) = open_beside(path)?;
    match std::fs::rename(&beside, path) {
        Ok(()) => Ok(file),
        Err(error) => {
            // As above.
            let _gone = std::fs::remove_file(&beside);
            Err(error)
        }
    }
}

/// A file that gets its name when it is whole.
pub(crate) struct Unfinished {
    pub(crate) file: File,
    beside: PathBuf,
    path: PathBuf,
    is_whole: bool,
}

/// Begins a file of that name.
///
/// # Errors
/// Of the system.
pub(crate) fn begin(path: &Path) -> io::Result<Unfinished> {
    let (beside, file) = open_beside(path)?;
    Ok(Unfinished {
        file,
        beside,
        path: path.to_owned(),
        is_whole: false,
    })
}

impl Unfinished {
    /// Gives it its name.
    ///
    /// # Errors
    /// Of the system.
    pub(crate) fn finish(mut self) -> io::Result<()> {
        self.file.flush()?;
        std::fs::rename(&self.beside, &self.path)?;
        self.is_whole = true;
        Ok(())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if !self.is_whole {
            // What failed before is told.
            let _gone = std::fs::remove_file(&self.beside);
        }
    }
}

fn open_beside(path: &Path) -> io::Result<(PathBuf, File)> {
    let name = path.file_name().ok_or(ErrorKind::InvalidInput)?;
    let name = format!(".{}.{}.part", name.to_string_lossy(), std::process::id());
    let beside = path.with_file_name(name);
    let open = || {
        OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&beside)
    };
    let file = match open() {
        // Of a killed process of the same number.
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            std::fs::remove_file(&beside)?;
            open()
        }
        opened => opened,
    };
    Ok((beside.clone(), file?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_is_replaced_and_what_it_points_to_stays() {
        let folder = std::env::temp_dir().join(format!("signorini-whole-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (target, link) = (folder.join("target"), folder.join("link"));
        std::fs::write(&target, "mine").unwrap();
        for _ in 0..2 {
            let _before = std::fs::remove_file(&link);
            std::os::unix::fs::symlink(&target, &link).unwrap();
            write(&link, b"whole").unwrap();
        }
        assert_eq!(std::fs::read_to_string(&link).unwrap(), "whole");
        std::fs::remove_file(&link).unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        create(&link).unwrap().write_all(b"line").unwrap();
        assert_eq!(std::fs::read_to_string(&link).unwrap(), "line");
        assert_eq!(std::fs::read_to_string(&target).unwrap(), "mine");
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_file_that_cannot_be_written_whole_leaves_the_one_before() {
        let missing = Path::new("/nonexistent/results.vtu");
        assert!(write(missing, b"text").is_err());
        assert!(create(missing).is_err());
        // A device without room is the disk that is full.
        let full = OpenOptions::new().write(true).open("/dev/full");
        if let Ok(mut full) = full {
            let error = full.write_all(b"text").unwrap_err();
            assert_eq!(error.kind(), ErrorKind::StorageFull);
        }
    }
}
