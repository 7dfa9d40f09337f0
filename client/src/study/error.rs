//! What can be wrong with a study, typed.

use std::path::PathBuf;

use crate::library::error::Violation;
use crate::scene_file::SceneFileError;

/// Why a study cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A file that cannot be read.
    #[error("{}: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// From the system.
        source: std::io::Error,
    },
    /// The study is not TOML; line and column are in the message.
    #[error("{}: not a TOML file: {message}", path.display())]
    Syntax {
        /// Of the study.
        path: PathBuf,
        /// For people.
        message: String,
    },
    /// Keys of the study that are wrong, at least one.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Invalid(Vec<Violation>),
    /// A table of cases that is wrong.
    #[error("{}: line {line}: {message}", path.display())]
    List {
        /// Of the table.
        path: PathBuf,
        /// Counted from 1.
        line: u64,
        /// For people.
        message: String,
    },
    /// The scene that is varied cannot be read.
    #[error("{}: {source}", path.display())]
    Scene {
        /// Of the scene.
        path: PathBuf,
        /// Why.
        source: SceneFileError,
    },
}
