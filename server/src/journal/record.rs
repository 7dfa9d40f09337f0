//! What is stored, as messages with room to grow, each under its seal.
//!
//! A seal is the first bytes of the SHA-256 of the message: pages of the database have
//! checksums of their own, which are looked at after a crash only.

use bytes::Bytes;
use prost::Message;
use sha2::{Digest, Sha256};

use super::error::JournalError;

/// Bytes of a seal.
const SEAL: usize = 8;

/// A session as it was asked for.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct StoredSession {
    /// The `CreateSessionRequest`, encoded.
    #[prost(bytes = "bytes", tag = "1")]
    pub(crate) request: Bytes,
    /// When it was made.
    #[prost(message, optional, tag = "2")]
    pub(crate) created: Option<prost_types::Timestamp>,
    /// `meshes/{digest}`.
    #[prost(string, tag = "3")]
    pub(crate) mesh: String,
    /// Name of the scene.
    #[prost(string, tag = "4")]
    pub(crate) scene_name: String,
    /// Name of the client that it belongs to; empty: it belongs to all, as one of a server
    /// without tokens does.
    #[prost(string, tag = "5")]
    pub(crate) owner: String,
}

/// An accepted update.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct StoredUpdate {
    /// The `SolveRequest` that brought it, encoded.
    #[prost(bytes = "bytes", tag = "1")]
    pub(crate) encoded: Bytes,
    /// Somebody asked it to stop before it was finished.
    #[prost(bool, tag = "2")]
    pub(crate) cancelled: bool,
}

/// One result, without its fields.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct StoredResult {
    /// Of its update.
    #[prost(int64, tag = "1")]
    pub(crate) sequence: i64,
    /// The `StepReport`, encoded.
    #[prost(bytes = "bytes", tag = "2")]
    pub(crate) report: Bytes,
    /// The last one of its update.
    #[prost(bool, tag = "3")]
    pub(crate) last: bool,
    /// Whether fields were due.
    #[prost(bool, tag = "4")]
    pub(crate) is_due: bool,
    /// Numbers of the fields that were asked for.
    #[prost(int32, repeated, tag = "5")]
    pub(crate) asked: Vec<i32>,
    /// Bytes of its fields.
    #[prost(uint64, tag = "6")]
    pub(crate) field_bytes: u64,
    /// When it was made, Unix seconds.
    #[prost(int64, tag = "7")]
    pub(crate) made: i64,
}

/// The fields of one result.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct StoredFields {
    /// Each once.
    #[prost(message, repeated, tag = "1")]
    pub(crate) fields: Vec<StoredField>,
}

/// One field.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct StoredField {
    /// Number of its name.
    #[prost(int32, tag = "1")]
    pub(crate) name: i32,
    /// Rows of its array.
    #[prost(uint64, tag = "2")]
    pub(crate) rows: u64,
    /// Columns of its array.
    #[prost(uint64, tag = "3")]
    pub(crate) components: u64,
    /// Little-endian doubles, row-major.
    #[prost(bytes = "bytes", tag = "4")]
    pub(crate) data: Bytes,
}

/// The state of a session after one of its results.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct StoredCheckpoint {
    /// Number of that result.
    #[prost(int64, tag = "1")]
    pub(crate) event: i64,
    /// Update of that result.
    #[prost(int64, tag = "2")]
    pub(crate) sequence: i64,
    /// Increments of that update that are done; 0 where the update is finished.
    #[prost(uint32, tag = "3")]
    pub(crate) done: u32,
    /// What the library wrote, where the solver knew nothing.
    #[prost(bytes = "bytes", tag = "4")]
    pub(crate) state: Bytes,
    /// What was done on it before.
    #[prost(message, repeated, tag = "5")]
    pub(crate) since: Vec<StoredWork>,
}

/// What an update did to a state, to be done again.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct StoredWork {
    /// The `SolveRequest` that brought the update, encoded.
    #[prost(bytes = "bytes", tag = "1")]
    pub(crate) encoded: Bytes,
    /// Increments of it that the state has already.
    #[prost(uint32, tag = "2")]
    pub(crate) before: u32,
    /// Increments after those.
    #[prost(uint32, tag = "3")]
    pub(crate) done: u32,
    /// Whether it was stopped then.
    #[prost(bool, tag = "4")]
    pub(crate) stopped: bool,
}

/// A state that a client may go back to.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct StoredSave {
    /// What the library wrote, where the solver knew nothing.
    #[prost(bytes = "bytes", tag = "1")]
    pub(crate) state: Bytes,
    /// What was done on it up to the state that is meant.
    #[prost(message, repeated, tag = "2")]
    pub(crate) since: Vec<StoredWork>,
}

/// A stored mesh, for lists.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct StoredMesh {
    /// Its description, a `StoredMesh` of the contract, encoded.
    #[prost(bytes = "bytes", tag = "1")]
    pub(crate) described: Bytes,
    /// Names of the clients that have sent it; none: it belongs to all.
    #[prost(string, repeated, tag = "2")]
    pub(crate) owners: Vec<String>,
}

/// A stored surface of a tool, for lists.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct StoredSurface {
    /// Its description, a `StoredSurface` of the contract, encoded.
    #[prost(bytes = "bytes", tag = "1")]
    pub(crate) described: Bytes,
    /// Names of the clients that have sent it; none: it belongs to all.
    #[prost(string, repeated, tag = "2")]
    pub(crate) owners: Vec<String>,
}

/// An imported state, whose bytes are in its file.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct StoredState {
    /// Name of the client that has sent it last; empty: one of a server without tokens.
    #[prost(string, tag = "1")]
    pub(crate) owner: String,
    /// When it came last, Unix milliseconds.
    #[prost(int64, tag = "2")]
    pub(crate) made: i64,
    /// Of its file.
    #[prost(uint64, tag = "3")]
    pub(crate) bytes: u64,
}

/// A message with its seal.
pub(super) fn sealed(message: &impl Message) -> Vec<u8> {
    let mut bytes = message.encode_to_vec();
    let seal = Sha256::digest(&bytes);
    bytes.extend(seal.iter().take(SEAL));
    bytes
}

/// The message under a seal; `what` names it where it is broken.
pub(super) fn opened<M: Message + Default>(bytes: &[u8], what: &str) -> Result<M, JournalError> {
    let damaged = || JournalError::Damaged(format!("{what} is not as it was written"));
    let (message, seal) = bytes.split_last_chunk::<SEAL>().ok_or_else(damaged)?;
    if Sha256::digest(message).starts_with(seal) {
        M::decode(message).map_err(|_| damaged())
    } else {
        Err(damaged())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_byte_breaks_the_seal() {
        let update = StoredUpdate {
            encoded: Bytes::from_static(b"an update"),
            cancelled: true,
        };
        let bytes = sealed(&update);
        assert_eq!(opened::<StoredUpdate>(&bytes, "it"), Ok(update));
        for place in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[place] ^= 1;
            assert!(opened::<StoredUpdate>(&changed, "it").is_err(), "{place}");
            let short = opened::<StoredUpdate>(&bytes[..place], "it");
            assert!(short.is_err(), "{place}");
        }
    }
}
