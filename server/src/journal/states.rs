//! Imported states: a file each, and an entry that says whose it is and how old.
//!
//! The file comes before its entry and goes after it: a kill between leaves a file that
//! the next start enters as one of nobody.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use super::database::{self, Change};
use super::error::JournalError;
use super::record::StoredState;
use super::{Journal, Urgency, files};

impl Journal {
    /// Keeps a state of `owner` under the digest that was computed from its bytes, and drops
    /// the oldest of the same owner beyond `most`. Blocks.
    ///
    /// # Errors
    /// [`JournalError::Unwritable`]; the state is not kept then.
    pub(crate) fn keep_state(
        &self,
        (digest, bytes): (&str, &[u8]),
        owner: &str,
        most: usize,
    ) -> Result<(), JournalError> {
        self.disk()
            .told(files::write(&self.state_file(digest), bytes))?;
        let entered = StoredState {
            owner: owner.to_owned(),
            made: now(),
            bytes: bytes.len() as u64,
        };
        let mut own = self.database.with(database::states)?;
        own.retain(|(other, state)| state.owner == owner && other != digest);
        own.sort_by_key(|(_, state)| state.made);
        let beyond = (own.len() + 1).saturating_sub(most);
        let dropped = own.into_iter().take(beyond).map(|(digest, _)| digest);
        let dropped: Vec<String> = dropped.collect();
        let mut changes = vec![Change::State(digest.to_owned(), entered)];
        changes.extend(dropped.iter().cloned().map(Change::DropState));
        self.write_now(changes)?;
        self.drop_state_files(&dropped)
    }

    /// Drops states. Blocks.
    pub(super) fn drop_states(&self, digests: Vec<String>) -> Result<(), JournalError> {
        if digests.is_empty() {
            return Ok(());
        }
        let dropped = digests.iter().cloned().map(Change::DropState);
        self.write_now(dropped.collect())?;
        self.drop_state_files(&digests)
    }

    /// The bytes of a state's file; none where there is no such file. Blocks.
    pub(crate) fn read_state(&self, digest: &str) -> Result<Option<Vec<u8>>, JournalError> {
        files::read(&self.state_file(digest))
    }

    /// Enters the files that have no entry, and drops the entries that have no file; how many of
    /// these there were.
    pub(super) fn match_states(&self) -> Result<usize, JournalError> {
        let entries = self.database.with(database::states)?;
        let entered: HashSet<&str> = entries.iter().map(|(digest, _)| digest.as_str()).collect();
        let found = files_of(&self.state_folder())?;
        let is_there = |digest: &str| found.iter().any(|(name, _)| name == digest);
        let lost = entered.iter().filter(|digest| !is_there(digest));
        let lost: Vec<String> = lost.map(|digest| (*digest).to_owned()).collect();
        for digest in &lost {
            tracing::error!(name = format!("states/{digest}"), "its file is gone");
        }
        let count = lost.len();
        let mut changes: Vec<Change> = lost.into_iter().map(Change::DropState).collect();
        let unknown = found
            .iter()
            .filter(|(name, _)| !entered.contains(name.as_str()));
        changes.extend(unknown.map(|(name, bytes)| {
            let state = StoredState {
                owner: String::new(),
                made: now(),
                bytes: *bytes,
            };
            Change::State(name.clone(), state)
        }));
        if !changes.is_empty() {
            self.write_now(changes)?;
        }
        Ok(count)
    }

    /// Returns when the disk has changes that belong to no session.
    pub(super) fn write_now(&self, changes: Vec<Change>) -> Result<(), JournalError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        let done = Box::new(move |outcome| {
            // Whoever asked waits below.
            let _left = sender.send(outcome);
        });
        self.submit("", changes, Urgency::Now, done);
        let closed = |_| JournalError::Unwritable("the server is shutting down".to_owned());
        receiver.recv().map_err(closed)?
    }

    fn drop_state_files(&self, digests: &[String]) -> Result<(), JournalError> {
        digests
            .iter()
            .try_for_each(|digest| files::remove(&self.state_file(digest)))
    }

    fn state_file(&self, digest: &str) -> PathBuf {
        self.state_folder().join(digest)
    }

    fn state_folder(&self) -> PathBuf {
        self.folder().join("states")
    }
}

/// Names and bytes of the files in a folder.
fn files_of(folder: &Path) -> Result<Vec<(String, u64)>, JournalError> {
    let wrong = |error: std::io::Error| JournalError::at(folder, &error);
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(wrong)? {
        let entry = entry.map_err(wrong)?;
        let bytes = entry.metadata().map_err(wrong)?.len();
        found.push((entry.file_name().to_string_lossy().into_owned(), bytes));
    }
    Ok(found)
}

/// Unix milliseconds: states may come fast.
fn now() -> i64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    i64::try_from(now.unwrap_or_default().as_millis()).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Limit;
    use crate::watch::metrics::Metrics;

    fn open(folder: &Path) -> Journal {
        Journal::open(folder, &Metrics::new().unwrap()).unwrap()
    }

    fn is_kept(journal: &Journal, digest: &str) -> bool {
        journal.read_state(digest).unwrap().is_some()
    }

    #[test]
    fn the_oldest_state_of_a_client_makes_room_and_a_limit_holds() {
        let name = format!("signorini-states-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        // Of an earlier process of the same number.
        drop(fs::remove_dir_all(&folder));
        let journal = open(&folder);
        journal.keep_state(("b0", b"other"), "line-2", 2).unwrap();
        for digest in ["a2", "a1", "a0"] {
            journal.keep_state((digest, b"state"), "line-1", 2).unwrap();
            // The clock of entries counts milliseconds.
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        let kept = ["a2", "a1", "a0", "b0"].map(|digest| is_kept(&journal, digest));
        assert_eq!(kept, [false, true, true, true]);
        // Those of a build that made no entries are entered; the count outlives the server.
        journal.close();
        fs::write(folder.join("states/c0"), b"state").unwrap();
        let journal = open(&folder);
        journal.keep_state(("a3", b"state"), "line-1", 2).unwrap();
        assert!(!is_kept(&journal, "a1") && is_kept(&journal, "c0"));
        let limit = Limit {
            bytes: 12,
            oldest: i64::MIN,
        };
        journal.trim(limit).unwrap();
        let kept = ["b0", "a0", "c0", "a3"].map(|digest| is_kept(&journal, digest));
        assert_eq!(kept, [false, false, true, true]);
        journal.close();
        fs::remove_dir_all(&folder).unwrap();
    }
}
