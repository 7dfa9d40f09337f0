//! Reads files that a user names: regular ones, up to a limit.

use std::fs::File;
use std::io::{self, ErrorKind, Read as _};
use std::path::Path;

/// Bytes that tell what a file is.
pub const HEAD: u64 = 1024;

/// All of a regular file of at most `most` bytes. A device or a pipe could have no end, or
/// no writer to begin with.
///
/// # Errors
/// What the system said, or that the file is none or too large.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    read_if(path, most, |_| Ok(()))
}

/// As [`read`], of a file whose first bytes `check` takes: at most [`HEAD`] of them.
///
/// # Errors
/// As [`read`], and what `check` says.
pub fn read_if<E: From<io::Error>>(
    path: &Path,
    most: u64,
    check: impl FnOnce(&[u8]) -> Result<(), E>,
) -> Result<Vec<u8>, E> {
    let mut file = open(path, most)?;
    let mut bytes = Vec::new();
    file.by_ref().take(HEAD).read_to_end(&mut bytes)?;
    check(&bytes)?;
    // One byte more tells of a file that grows, or does not say how long it is.
    file.take((most + 1).saturating_sub(bytes.len() as u64))
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(refusal(format!("has more than {most} bytes")).into());
    }
    Ok(bytes)
}

fn refusal(why: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidInput, why)
}

/// A regular file that says it has at most `most` bytes.
fn open(path: &Path, most: u64) -> io::Result<File> {
    let found = std::fs::metadata(path)?;
    if !found.is_file() {
        return Err(refusal("no regular file".to_owned()));
    }
    if found.len() > most {
        return Err(refusal(format!("has more than {most} bytes")));
    }
    File::open(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_folders_and_long_files_are_refused() {
        for (path, said) in [
            ("/dev/zero", "no regular file"),
            ("/tmp", "no regular file"),
        ] {
            let refused = read(Path::new(path), 100).unwrap_err();
            assert_eq!(refused.to_string(), said, "{path}");
        }
        let path = std::env::temp_dir().join(format!("signorini-bounded-{}", std::process::id()));
        std::fs::write(&path, b"12345").unwrap();
        assert_eq!(read(&path, 5).unwrap(), b"12345");
        let long = read(&path, 4).unwrap_err();
        assert_eq!(long.to_string(), "has more than 4 bytes");
        std::fs::remove_file(&path).unwrap();
    }
}
