//! Exported states: the bytes that travel, and those that were imported.
//!
//! ```text
//! magic | version u32 | message: scene, state of the library, what was done since | SHA-256
//! ```
//!
//! Little-endian. The digest covers all that stands before it. A state is named by the
//! digest of all its bytes.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bytes::Bytes;
use prost::Message;
use sha2::{Digest, Sha256};

use crate::door::client_name::ClientName;
use crate::fault::{Fault, UploadKind};
use crate::journal::{Journal, StoredWork};
use crate::registry::planning::{aside, unwritable};
use crate::uploads::store::Reservation;

const MAGIC: &[u8; 16] = b"signorini-state\n";
/// Of this format, where nothing was done since; the library's state inside has its own.
const VERSION: u32 = 1;
/// Of the format with what was done since.
const WITH_SINCE: u32 = 2;
const DIGEST: usize = 32;
const PREFIX: &str = "states/";
/// States that a server keeps of one client; the oldest goes first.
const MOST_KEPT: usize = 64;

/// A state with what it belongs to.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct State {
    /// The scene, encoded.
    #[prost(bytes = "bytes", tag = "1")]
    pub(crate) scene: Bytes,
    /// What the library wrote.
    #[prost(bytes = "bytes", tag = "2")]
    pub(crate) state: Bytes,
    /// What was done on that up to the state that is meant.
    #[prost(message, repeated, tag = "3")]
    pub(crate) since: Vec<StoredWork>,
}

impl State {
    /// The bytes that travel.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        let version = if self.since.is_empty() {
            VERSION
        } else {
            WITH_SINCE
        };
        bytes.extend(version.to_le_bytes());
        bytes.extend(self.encode_to_vec());
        let digest = Sha256::digest(&bytes);
        bytes.extend(digest);
        bytes
    }

    /// From bytes that came from anywhere.
    ///
    /// # Errors
    /// `StateInvalid` with what is wrong first.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Result<Self, Fault> {
        let invalid = |why: &str| Fault::StateInvalid(why.to_owned());
        let rest = bytes.strip_prefix(MAGIC);
        let rest = rest.ok_or_else(|| invalid("these bytes are no state of a session"))?;
        let damaged = || invalid("the state is damaged: it is cut short, or its digest differs");
        let (version, rest) = rest.split_first_chunk().ok_or_else(damaged)?;
        let found = u32::from_le_bytes(*version);
        if !(VERSION..=WITH_SINCE).contains(&found) {
            let why = format!("a state of version {found}; this server reads version {WITH_SINCE}");
            return Err(invalid(&why));
        }
        let (message, digest) = rest.split_last_chunk::<DIGEST>().ok_or_else(damaged)?;
        let covered = bytes.get(..bytes.len() - DIGEST).unwrap_or_default();
        if Sha256::digest(covered)[..] == digest[..] {
            Self::decode(message).map_err(|_| damaged())
        } else {
            Err(damaged())
        }
    }
}

/// SHA-256 in hexadecimal digits.
pub(crate) fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

/// `states/{digest}`.
pub(crate) fn name(digest: &str) -> String {
    format!("{PREFIX}{digest}")
}

/// Imported states: in the data folder, or without one in memory.
#[derive(Default)]
pub(crate) struct States {
    kept: Mutex<VecDeque<Kept>>,
}

/// A state in memory.
struct Kept {
    digest: String,
    /// Who sent it last.
    owner: Option<ClientName>,
    bytes: Bytes,
    _held: Reservation,
}

impl States {
    /// Keeps bytes of `owner` whose digest this server has computed.
    pub(crate) async fn keep(
        &self,
        journal: Option<&Arc<Journal>>,
        (digest, owner): (&str, Option<ClientName>),
        (bytes, reservation): (Bytes, Reservation),
    ) -> Result<(), Fault> {
        if let Some(journal) = journal.cloned() {
            let digest = digest.to_owned();
            let owner = owner.map_or_else(String::new, |name| name.to_string());
            let write = move || journal.keep_state((&digest, &bytes), &owner, MOST_KEPT);
            let written = aside(write).await?.map_err(unwritable);
            drop(reservation);
            return written;
        }
        let mut kept = self.lock();
        kept.retain(|one| one.digest != digest);
        kept.push_back(Kept {
            digest: digest.to_owned(),
            owner,
            bytes,
            _held: reservation,
        });
        if kept.iter().filter(|one| one.owner == owner).count() > MOST_KEPT {
            let oldest = kept.iter().position(|one| one.owner == owner);
            oldest.and_then(|oldest| kept.remove(oldest));
        }
        Ok(())
    }

    /// The state of that name.
    pub(crate) async fn get(
        &self,
        journal: Option<&Arc<Journal>>,
        name: &str,
    ) -> Result<State, Fault> {
        let wanted = checked(name)?;
        let found = match journal.cloned() {
            Some(journal) => {
                let read = move || {
                    journal
                        .read_state(&wanted)
                        .map(|bytes| bytes.map(Bytes::from))
                };
                aside(read).await?.map_err(unwritable)?
            }
            None => {
                let kept = self.lock();
                let mut all = kept.iter();
                let found = all.find(|one| one.digest == wanted);
                found.map(|one| one.bytes.clone())
            }
        };
        let found = found.ok_or_else(|| Fault::StateNotFound(name.to_owned()))?;
        if self::name(&digest(&found)) == name {
            State::from_bytes(&found)
        } else {
            Err(Fault::UploadDamaged {
                kind: UploadKind::State,
                name: name.to_owned(),
                why: "its digest differs".to_owned(),
            })
        }
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<Kept>> {
        // No code of others runs under the lock, so what it holds is whole.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The digest in `states/{digest}`, which may name a file: hexadecimal digits only.
fn checked(name: &str) -> Result<String, Fault> {
    let is_digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
    let digest = name.strip_prefix(PREFIX);
    let digest = digest.filter(|text| text.len() == 2 * DIGEST && text.bytes().all(is_digit));
    let rule = || Fault::request("from_state", "must be `states/` and 64 hexadecimal digits");
    digest.map(ToOwned::to_owned).ok_or_else(rule)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state() -> State {
        State {
            scene: Bytes::from_static(b"a scene"),
            state: Bytes::from_static(b"a state"),
            since: vec![StoredWork::default()],
        }
    }

    #[test]
    fn every_change_of_a_state_is_refused() {
        let bytes = state().to_bytes();
        assert_eq!(State::from_bytes(&bytes), Ok(state()));
        for place in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[place] ^= 0x10;
            let refused = State::from_bytes(&changed);
            assert!(matches!(refused, Err(Fault::StateInvalid(_))), "{place}");
            let refused = State::from_bytes(&bytes[..place]);
            assert!(matches!(refused, Err(Fault::StateInvalid(_))), "{place}");
        }
    }

    #[test]
    fn a_later_version_is_named() {
        let mut bytes = state().to_bytes();
        bytes[MAGIC.len()] = 9;
        let Err(Fault::StateInvalid(why)) = State::from_bytes(&bytes) else {
            panic!("a later version is refused");
        };
        assert!(why.contains("version 9"), "{why}");
    }

    #[test]
    fn random_bytes_are_no_state_and_no_panic() {
        let mut random = fastrand::Rng::with_seed(17);
        for _ in 0..20_000 {
            let mut bytes = if random.bool() {
                state().to_bytes()
            } else {
                std::iter::repeat_with(|| random.u8(..)).take(80).collect()
            };
            for _ in 0..random.usize(1..4) {
                let place = random.usize(..bytes.len());
                bytes[place] = random.u8(..);
            }
            if random.bool() {
                // The seal of what is there: only the message may be wrong.
                let end = bytes.len() - DIGEST;
                let seal = Sha256::digest(&bytes[..end]);
                bytes[end..].copy_from_slice(&seal);
            }
            if let Err(fault) = State::from_bytes(&bytes) {
                assert!(matches!(fault, Fault::StateInvalid(_)), "{fault}");
            }
        }
    }

    #[test]
    fn only_digests_name_files() {
        let digest = "0".repeat(64);
        assert_eq!(checked(&name(&digest)), Ok(digest.clone()));
        for bad in [
            "states/",
            "states/../x",
            &digest,
            "states/ABCD",
            &format!("states/{digest}0"),
        ] {
            assert!(checked(bad).is_err(), "{bad}");
        }
    }
}
