//! Why the data folder does not serve.

use std::path::Path;

/// The data folder cannot be used, or not now.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum JournalError {
    /// The folder or a file of it cannot be opened or made.
    #[error("{path}: {why}")]
    Folder {
        /// What was opened.
        path: String,
        /// What the system said.
        why: String,
    },
    /// Another process has the folder open.
    #[error("{0}: another server uses this data folder")]
    InUse(String),
    /// Written in a format that this build does not know.
    #[error("{path}: data of format {found}; this build reads format {known}")]
    Version {
        /// The folder.
        path: String,
        /// What it says of itself.
        found: String,
        /// What this build writes.
        known: u32,
    },
    /// Nothing can be written now; what was acknowledged is there.
    #[error("the data folder cannot be written: {0}")]
    Unwritable(String),
    /// Another server of the fleet has the session, or may have it.
    #[error("another server has `{0}`, or may have it")]
    Elsewhere(String),
    /// What is stored is not what was written.
    #[error("the data folder is damaged: {0}")]
    Damaged(String),
}

impl JournalError {
    /// What went wrong with `path`.
    pub(super) fn at(path: &Path, why: &dyn std::fmt::Display) -> Self {
        Self::Folder {
            path: path.display().to_string(),
            why: why.to_string(),
        }
    }
}

impl From<redb::StorageError> for JournalError {
    fn from(error: redb::StorageError) -> Self {
        redb::Error::from(error).into()
    }
}

impl From<redb::TableError> for JournalError {
    fn from(error: redb::TableError) -> Self {
        redb::Error::from(error).into()
    }
}

impl From<redb::TransactionError> for JournalError {
    fn from(error: redb::TransactionError) -> Self {
        redb::Error::from(error).into()
    }
}

impl From<redb::CommitError> for JournalError {
    fn from(error: redb::CommitError) -> Self {
        redb::Error::from(error).into()
    }
}

impl From<redb::Error> for JournalError {
    fn from(error: redb::Error) -> Self {
        let text = error.to_string();
        if matches!(error, redb::Error::Corrupted(_)) {
            Self::Damaged(text)
        } else {
            Self::Unwritable(text)
        }
    }
}
