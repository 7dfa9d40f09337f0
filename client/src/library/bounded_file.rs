//! Reads files that a user names: regular ones, up to a limit.

use std::fs::File;
use std::io::{self, ErrorKind, Read as _};
use std::path::Path;

/// All of a regular file of at most `most` bytes. A device or a pipe could have no end, or
/// no writer to begin with.
///
/// # Errors
/// What the system said, or that the file is none or too large.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let found = std::fs::metadata(path)?;
    let refused = |why: String| Err(io::Error::new(ErrorKind::InvalidInput, why));
    if !found.is_file() {
        return refused("no regular file".to_owned());
    }
    let mut bytes = Vec::new();
    if found.len() <= most {
        // One byte more tells of a file that grows, or does not say how long it is.
        File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    }
    if found.len() > most || bytes.len() as u64 > most {
        refused(format!("has more than {most} bytes"))
    } else {
        Ok(bytes)
    }
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
