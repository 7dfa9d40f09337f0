//! The data folder: what the server acknowledged and has to know after a kill.
//!
//! ```text
//! FORMAT            version of all of this
//! journal.redb      sessions, accepted updates, results, checkpoints
//! meshes/{digest}   meshes, named by their content
//! states/{digest}   exported states, named by their content
//! surfaces/{digest} surfaces of tools, named by their content
//! ```
//!
//! One thread writes: it takes all changes that wait, commits them at once, and tells
//! their owners when the disk has them. The room knows bytes and names; what they mean
//! is known to sessions. A name in the folder is a digest that this server computed.

mod backup;
mod database;
mod disk;
mod error;
#[cfg(feature = "fleet")]
mod fenced;
mod files;
mod inspect;
mod layout;
mod presence;
mod record;
mod retention;
mod shared;
mod states;
mod uploads;
mod writer;

use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};

use redb::Database;

use crate::config::Limit;
use crate::watch::metrics::Metrics;

pub use backup::Copying;
pub(crate) use database::{Change, Listed, Stored};
pub(crate) use disk::Disk;
pub use error::JournalError;
#[cfg(feature = "fleet")]
pub(crate) use fenced::Fence;
pub(crate) use files::{Part, close_file, copy_bytes, make_folder, sync_folder};
pub(crate) use inspect::inspect;
use layout::DATABASE_FILE;
pub(crate) use presence::Presence;
pub(crate) use record::{
    StoredCheckpoint, StoredField, StoredFields, StoredMesh, StoredResult, StoredSave,
    StoredSession, StoredSurface, StoredUpdate, StoredWork,
};
use shared::Shared;
use writer::Writer;

/// Folders in it.
const PARTS: [&str; 3] = ["meshes", "states", "surfaces"];

/// Called when the disk has a change, or when it will not get it.
pub(crate) type Done = Box<dyn FnOnce(Result<(), JournalError>) + Send>;

/// How soon changes shall reach the disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Urgency {
    /// Somebody waits.
    Now,
    /// With the next that somebody waits for, or a moment later.
    Soon,
}

/// The data folder of a running server.
pub(crate) struct Journal {
    folder: PathBuf,
    database: Arc<Shelf>,
    disk: Arc<Disk>,
    writer: Writer,
    shared: Shared,
}

/// Where the open database lies: nowhere while a disk that failed is not back.
pub(crate) struct Shelf {
    path: PathBuf,
    database: RwLock<Option<Database>>,
}

impl Shelf {
    /// Runs `work` on the database.
    fn with<T>(
        &self,
        work: impl FnOnce(&Database) -> Result<T, JournalError>,
    ) -> Result<T, JournalError> {
        let guard = self.database.read().unwrap_or_else(PoisonError::into_inner);
        let gone = || JournalError::Unwritable("the disk failed and is not back yet".to_owned());
        let database = guard.as_ref().ok_or_else(gone)?;
        guarded(|| work(database))
    }

    /// Gives the database back: another server may open it.
    fn close(&self) {
        let mut guard = self
            .database
            .write()
            .unwrap_or_else(PoisonError::into_inner);
        *guard = None;
    }

    /// Closes the database after a failure and opens it again, which brings back what
    /// was committed.
    fn reopen(&self) -> Result<(), JournalError> {
        let mut guard = self
            .database
            .write()
            .unwrap_or_else(PoisonError::into_inner);
        *guard = None;
        *guard = Some(database::open(&self.path)?);
        Ok(())
    }
}

impl Journal {
    /// Opens a data folder, or makes it.
    ///
    /// # Errors
    /// [`JournalError`] for a folder that cannot be used, is used already, has another
    /// format or is damaged.
    pub(crate) fn open(folder: &Path, metrics: &Arc<Metrics>) -> Result<Self, JournalError> {
        make_folder(folder)?;
        for part in PARTS {
            make_folder(&folder.join(part))?;
        }
        layout::prepare(folder)?;
        let path = folder.join(DATABASE_FILE);
        let opened = database::open(&path)?;
        guarded(|| database::make_tables(&opened))?;
        // Now that no other server can be at work in it.
        for part in PARTS {
            files::drop_parts(&folder.join(part))?;
        }
        let database = Arc::new(Shelf {
            path,
            database: RwLock::new(Some(opened)),
        });
        let disk = Disk::of(folder, metrics);
        let writer = Writer::start(Arc::clone(&database), &disk, metrics)
            .map_err(|error| JournalError::at(folder, &error))?;
        let journal = Self {
            folder: folder.to_owned(),
            database,
            disk,
            writer,
            shared: Shared::default(),
        };
        let lost = journal.match_states()?;
        (0..lost).for_each(|_| metrics.damaged("state"));
        Ok(journal)
    }

    /// Hands changes of the session `name` to the disk, in order; `done` is called once.
    pub(crate) fn submit(&self, name: &str, changes: Vec<Change>, urgency: Urgency, done: Done) {
        self.writer.submit(name, changes, urgency, done);
    }

    /// As [`Journal::submit`]; returns when the disk has them.
    ///
    /// # Errors
    /// [`JournalError::Unwritable`]; none of them is stored then.
    pub(crate) async fn store(&self, name: &str, changes: Vec<Change>) -> Result<(), JournalError> {
        let (sender, receiver) = tokio::sync::oneshot::channel();
        let done = Box::new(move |outcome| {
            // Whoever asked may have left.
            let _left = sender.send(outcome);
        });
        self.submit(name, changes, Urgency::Now, done);
        let closed = |_| JournalError::Unwritable("the server is shutting down".to_owned());
        receiver.await.map_err(closed)?
    }

    /// As [`Journal::store`], of what the fence has already.
    #[cfg(feature = "fleet")]
    async fn store_adopted(&self, name: &str, changes: Vec<Change>) -> Result<(), JournalError> {
        let (sender, receiver) = tokio::sync::oneshot::channel();
        let done = Box::new(move |outcome| {
            // Whoever asked may have left.
            let _left = sender.send(outcome);
        });
        self.writer.adopt(name, changes, done);
        let closed = |_| JournalError::Unwritable("the server is shutting down".to_owned());
        receiver.await.map_err(closed)?
    }

    /// Every stored session. Blocks.
    pub(crate) fn sessions(&self) -> Result<Vec<(String, Listed)>, JournalError> {
        self.database.with(database::list)
    }

    /// What a list tells of one session; none where it is not stored or not readable
    /// now. Blocks.
    pub(crate) fn listed(&self, name: &str) -> Option<Listed> {
        let found = self.database.with(|open| database::list_one(open, name));
        found.unwrap_or_else(|why| {
            tracing::error!(why = why.to_string(), "a session cannot be read");
            None
        })
    }

    /// All of one session. Blocks.
    pub(crate) fn load(&self, name: &str) -> Result<Option<Stored>, JournalError> {
        self.database.with(|open| database::load(open, name))
    }

    /// Drops results and states that the limit does not allow to stay; how many sessions have
    /// lost some. Blocks.
    pub(crate) fn trim(&self, limit: Limit) -> Result<usize, JournalError> {
        let outdated = self
            .database
            .with(|open| retention::outdated(open, limit))?;
        for (name, first) in &outdated.results {
            let dropped = vec![Change::DropResults(*first)];
            self.submit(name, dropped, Urgency::Soon, Box::new(|_| {}));
        }
        self.drop_states(outdated.states)?;
        Ok(outdated.results.len())
    }

    /// Copies everything as it is now into `target`, which must not exist. Blocks.
    ///
    /// # Errors
    /// When something cannot be read or written.
    pub(crate) fn backup(&self, target: &Path, copying: Copying) -> Result<(), JournalError> {
        self.database
            .with(|open| backup::copy(open, (&self.folder, target), copying))
    }

    /// As [`Journal::backup`], of a folder that no server uses. Blocks.
    pub(crate) fn copy(folder: &Path, target: &Path, copying: Copying) -> Result<(), JournalError> {
        layout::check(folder)?;
        let open = database::open(&folder.join(DATABASE_FILE))?;
        // A table that a later build than the folder's last one knows.
        guarded(|| database::make_tables(&open))?;
        guarded(|| backup::copy(&open, (folder, target), copying))
    }

    /// What is known of its disk.
    pub(crate) fn disk(&self) -> &Arc<Disk> {
        &self.disk
    }

    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns when everything submitted so far is written; later changes are lost.
    pub(crate) fn close(&self) {
        self.writer.close();
        self.database.close();
    }
}

/// Runs `work` on pages that may not be as they were written, at which the database panics.
fn guarded<T>(work: impl FnOnce() -> Result<T, JournalError>) -> Result<T, JournalError> {
    let damaged = |_| JournalError::Damaged("a page is not as it was written".to_owned());
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)).map_err(damaged)?
}
