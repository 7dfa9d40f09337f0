//! Whether a folder is a data folder, becomes one, or is what is left of one.
//!
//! A new one gets its database first and `FORMAT` last: nothing is acknowledged before,
//! so that a database without `FORMAT` and without entries is a start that was killed.
//! Whatever else is not whole is refused, because a new journal in its place would
//! forget in silence what was acknowledged.

use std::fs::{self, File};
use std::path::Path;

use super::error::JournalError;
use super::{PARTS, database, files};

/// Of the layout of the folder, the tables and the messages in them.
const FORMAT: u32 = 1;
pub(super) const FORMAT_FILE: &str = "FORMAT";
pub(super) const DATABASE_FILE: &str = "journal.redb";

/// Makes what a new data folder holds; one that is there has to be whole.
pub(super) fn prepare(folder: &Path) -> Result<(), JournalError> {
    let wrong = |error: std::io::Error| JournalError::at(folder, &error);
    let turn = File::open(folder).map_err(wrong)?;
    // Of two first starts at one time the second finds what the first has made; a file
    // system without such locks has none to offer.
    let _taken = turn.lock();
    if folder.join(FORMAT_FILE).exists() {
        return check(folder);
    }
    let database = folder.join(DATABASE_FILE);
    let has_entries = is_filled(&database) && !database::is_unused(&database)?;
    if has_entries || has_files(folder) {
        return Err(lost(folder, "it has entries and no file FORMAT"));
    }
    if !is_filled(&database) {
        database::create(&database)?;
    }
    files::write(&folder.join(FORMAT_FILE), format().as_bytes())
}

/// Refuses what is no data folder of this format, or not all of one.
pub(super) fn check(folder: &Path) -> Result<(), JournalError> {
    let path = folder.join(FORMAT_FILE);
    match files::read(&path)? {
        None => {
            return Err(JournalError::at(
                folder,
                &"no data folder: it has no file FORMAT",
            ));
        }
        Some(text) if text == format().as_bytes() => {}
        Some(text) => {
            let text = String::from_utf8_lossy(&text);
            return Err(JournalError::Version {
                path: folder.display().to_string(),
                found: text.trim().chars().take(80).collect(),
                known: FORMAT,
            });
        }
    }
    if is_filled(&folder.join(DATABASE_FILE)) {
        Ok(())
    } else {
        Err(lost(folder, "its file journal.redb is missing or empty"))
    }
}

fn format() -> String {
    format!("signorini data {FORMAT}\n")
}

fn is_filled(file: &Path) -> bool {
    fs::metadata(file).is_ok_and(|found| found.len() > 0)
}

fn has_files(folder: &Path) -> bool {
    let entries = PARTS.map(|part| fs::read_dir(folder.join(part)));
    entries.into_iter().flatten().flatten().next().is_some()
}

fn lost(folder: &Path, what: &str) -> JournalError {
    JournalError::Damaged(format!(
        "{}: {what}; `signorini restore` makes a folder from a backup, and a server begins anew \
         where this folder is moved away",
        folder.display()
    ))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::journal::{Change, Journal, StoredSession, inspect};
    use crate::watch::metrics::Metrics;

    fn folder(name: &str) -> PathBuf {
        let name = format!("signorini-layout-{name}-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        // Of an earlier process of the same number.
        drop(fs::remove_dir_all(&folder));
        folder
    }

    fn open(folder: &Path) -> Result<Journal, JournalError> {
        Journal::open(folder, &Metrics::new().unwrap())
    }

    /// A data folder with one session.
    async fn filled(folder: &Path) {
        let journal = open(folder).unwrap();
        let made = vec![Change::Session(StoredSession::default())];
        journal.store("sessions/one", made).await.unwrap();
        journal.close();
    }

    #[tokio::test]
    async fn what_is_left_of_a_data_folder_is_no_new_one() {
        let folder = folder("left");
        filled(&folder).await;
        let (database, format) = (folder.join(DATABASE_FILE), folder.join(FORMAT_FILE));
        let bytes = fs::read(&database).unwrap();
        let refused = || {
            for refused in [open(&folder).err(), inspect(&folder).err()] {
                let refused = refused.unwrap().to_string();
                assert!(refused.contains(folder.to_str().unwrap()), "{refused}");
            }
        };
        fs::remove_file(&database).unwrap();
        refused();
        assert!(!database.exists(), "nobody makes it again");
        fs::write(&database, b"").unwrap();
        refused();
        fs::write(&database, bytes).unwrap();
        fs::remove_file(&format).unwrap();
        refused();
        fs::write(&format, super::format()).unwrap();
        let journal = open(&folder).unwrap();
        assert_eq!(journal.sessions().unwrap().len(), 1);
        journal.close();
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_second_server_leaves_the_parts_of_the_first_alone() {
        let folder = folder("second");
        let first = open(&folder).unwrap();
        let part = folder.join("meshes/3.part");
        fs::write(&part, b"under way").unwrap();
        assert!(matches!(open(&folder), Err(JournalError::InUse(_))));
        assert!(part.exists());
        first.close();
        open(&folder).unwrap().close();
        assert!(!part.exists(), "nobody goes on with it");
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_first_start_that_was_killed_goes_on() {
        let folder = folder("killed");
        for killed in [&[DATABASE_FILE, FORMAT_FILE][..], &[FORMAT_FILE]] {
            open(&folder).unwrap().close();
            for file in killed {
                fs::remove_file(folder.join(file)).unwrap();
            }
            fs::write(folder.join("journal.part"), b"half").unwrap();
        }
        open(&folder).unwrap().close();
        fs::remove_dir_all(&folder).unwrap();
    }
}
