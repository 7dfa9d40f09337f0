//! Whether the disk of a data folder takes what is written to it, and how much room it has left.
//!
//! Whoever writes tells how that went. While the newest word is a refusal, a look tries a write
//! of its own, so that a server is ready again without a client's help.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::error::JournalError;
use super::files::Part;
use crate::watch::metrics::Metrics;

/// Bytes of a write that is tried: what a server needs to do anything at all.
const TRIED: usize = 1 << 20;

/// What is known of the disk of one data folder.
pub(crate) struct Disk {
    folder: PathBuf,
    /// What the newest write met, where it was refused.
    refusal: Mutex<Option<String>>,
    metrics: Arc<Metrics>,
}

impl Disk {
    /// That of a data folder which is open.
    pub(super) fn of(folder: &Path, metrics: &Arc<Metrics>) -> Arc<Self> {
        Arc::new(Self {
            folder: folder.to_owned(),
            refusal: Mutex::default(),
            metrics: Arc::clone(metrics),
        })
    }

    /// The disk has refused a write.
    pub(super) fn refused(&self, why: &JournalError) {
        self.metrics.journal_failed();
        *self.lock() = Some(why.to_string());
        self.metrics.data_unwritable(true);
    }

    /// The disk has taken a write.
    pub(super) fn took(&self) {
        if self.lock().take().is_some() {
            self.metrics.data_unwritable(false);
            tracing::warn!("the data folder can be written again");
        }
    }

    /// Tells how the write of a file went.
    pub(super) fn told<T>(&self, outcome: Result<T, JournalError>) -> Result<T, JournalError> {
        match &outcome {
            Ok(_) => self.took(),
            Err(why @ JournalError::Unwritable(_)) => self.refused(why),
            Err(_) => {}
        }
        outcome
    }

    /// What a client is told while nothing can be written.
    pub(crate) fn refusal(&self) -> Option<String> {
        self.lock().clone()
    }

    /// Measures the room, and tries a write if the newest one was refused. Blocks.
    pub(crate) fn look(&self) {
        // Of a folder that is gone nothing can be known, which is told elsewhere.
        if let Ok(found) = rustix::fs::statvfs(&self.folder) {
            let bytes = |blocks: u64| blocks.saturating_mul(found.f_frsize);
            self.metrics
                .data_room(bytes(found.f_bavail), bytes(found.f_blocks));
        }
        if self.refusal().is_some() && self.try_a_write().is_ok() {
            self.took();
        }
    }

    fn try_a_write(&self) -> Result<(), JournalError> {
        // Without a name it goes when it is dropped, or with the next start.
        Part::write(&self.folder.join("meshes"), |put| put(&[0; TRIED])).map(drop)
    }

    fn lock(&self) -> MutexGuard<'_, Option<String>> {
        self.refusal.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_that_takes_a_write_again_is_found_by_a_look() {
        let name = format!("signorini-disk-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        let metrics = Metrics::new().unwrap();
        let disk = Disk::of(&folder, &metrics);
        let told = |line: &str| metrics.render().lines().any(|found| found == line);
        disk.refused(&JournalError::Unwritable("no room".to_owned()));
        assert!(disk.refusal().unwrap().contains("no room"));
        // There is nothing to write to yet.
        disk.look();
        assert!(disk.refusal().is_some() && told("signorini_data_unwritable 1"));
        std::fs::create_dir_all(folder.join("meshes")).unwrap();
        disk.look();
        assert!(disk.refusal().is_none() && told("signorini_data_unwritable 0"));
        assert!(told("signorini_journal_failures_total 1") && !told("signorini_data_free_bytes 0"));
        let left = std::fs::read_dir(folder.join("meshes")).unwrap().count();
        assert_eq!(left, 0);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
