//! Why bytes are not taken as a checkpoint.

use std::fmt;

use thiserror::Error;

/// What a checkpoint goes on upon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The mesh, by its content.
    Mesh,
    /// The scene, but for its name and its limit of time.
    Scene,
    /// The prepared data: the decisions of the plan.
    Prepared,
    /// The instruction set of the kernels: another one rounds differently.
    InstructionSet,
}

impl Origin {
    /// The refusal of a checkpoint `written` upon another one than that `here`.
    pub(super) fn differs(self, written: &[u8], here: &[u8]) -> CheckpointError {
        CheckpointError::Foreign {
            origin: self,
            written: self.shown(written),
            here: self.shown(here),
        }
    }

    /// Digests as hexadecimal digits, names as they are.
    fn shown(self, bytes: &[u8]) -> String {
        match self {
            Self::Mesh | Self::Scene | Self::Prepared => {
                bytes.iter().map(|byte| format!("{byte:02x}")).collect()
            }
            Self::InstructionSet => String::from_utf8_lossy(bytes).into_owned(),
        }
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Mesh => "mesh",
            Self::Scene => "scene",
            Self::Prepared => "prepared data",
            Self::InstructionSet => "instruction set",
        })
    }
}

/// Bytes that no session goes on from.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// Not made by [`crate::Session::export`].
    #[error("these bytes are not a checkpoint of a session")]
    NotACheckpoint,
    /// Made by a build with another format.
    #[error("a checkpoint of version {found} cannot be read; this build knows version {known}")]
    UnknownVersion {
        /// Version of the bytes.
        found: u32,
        /// Version that this build reads and writes.
        known: u32,
    },
    /// Cut short or changed since they were written.
    #[error("the checkpoint is damaged: it is cut short, or its SHA-256 digest differs")]
    Damaged,
    /// Of a session on something else.
    #[error("the checkpoint is of another {origin}: `{written}`, here `{here}`")]
    Foreign {
        /// What differs first.
        origin: Origin,
        /// Digest or name that the checkpoint was written upon.
        written: String,
        /// Digest or name of this session.
        here: String,
    },
    /// A value that no session writes.
    #[error("the checkpoint is malformed: `{field}` {fault}")]
    Malformed {
        /// The first faulty field.
        field: &'static str,
        /// What is wrong with it.
        fault: &'static str,
    },
}
