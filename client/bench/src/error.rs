//! Why a bench has no result.

use std::path::{Path, PathBuf};

/// What keeps a bench from being measured or written.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The arguments ask for nothing that can be measured. The message.
    #[error("{0}")]
    Arguments(String),
    /// The figures of other solvers cannot be read. File, line and fault.
    #[error("{0}")]
    Peers(String),
    /// A level beyond those that the program carries.
    #[error(
        "mesh {file}: not carried by this program and not in {folder}; \
         tests/meshes/generate.py makes it, --meshes DIR names its folder"
    )]
    NoMesh {
        /// Name of the file.
        file: String,
        /// Where it was looked for.
        folder: String,
    },
    /// A file or folder that cannot be written.
    #[error("{path}: {error}")]
    Unwritable {
        /// The file or folder.
        path: PathBuf,
        /// From the system.
        error: std::io::Error,
    },
    /// The rows do not become a table. The message.
    #[error("{0}")]
    Table(String),
}

impl BenchError {
    /// Names the path of a write that failed.
    pub(crate) fn unwritable(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |error| Self::Unwritable {
            path: path.to_owned(),
            error,
        }
    }
}
