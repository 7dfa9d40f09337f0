//! The token file: names with their roles, and what proves each.
//!
//! ```toml
//! [[token]]
//! name = "line-1"
//! role = "solve"
//! sha256 = "..."      # of the token; left out: a certificate of this common name
//! created = "2026-01-01T00:00:00Z"
//! ```
//!
//! A token is 256 random bits, so that a plain digest of it is as good as a slow one. Every digest
//! of the file is compared, each in a time that tells nothing.

use std::path::Path;
use std::time::SystemTime;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use subtle::{ConditionallySelectable, ConstantTimeEq};
use tokio_rustls::rustls::crypto::ring;

use super::{AccessError, Role, files};
use crate::door::client_name::ClientName;

/// Begins every token, so that searches for lost ones find it.
const PREFIX: &str = "signorini_";
/// Random bytes of a token.
const SECRET: usize = 32;
/// Longest token that is looked at.
const LONGEST: usize = 256;
/// Longest file: some 20 000 entries.
const LONGEST_FILE: u64 = 4 << 20;
/// Digits of a digest that name an entry.
const ID: usize = 8;

type Digest256 = [u8; 32];

/// One line of the file: a name, its role and what proves it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    name: ClientName,
    role: Role,
    /// None: a certificate of that common name.
    digest: Option<Digest256>,
    created: String,
}

/// As it stands in the file.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Written {
    name: String,
    role: Role,
    #[serde(skip_serializing_if = "Option::is_none")]
    sha256: Option<String>,
    #[serde(default)]
    created: String,
}

#[derive(Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct WrittenFile {
    #[serde(default)]
    token: Vec<Written>,
}

/// All entries of a token file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TokenFile {
    entries: Vec<Entry>,
}

/// What a new entry proves its name by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NewToken {
    /// A token that is made and shown once.
    Bearer,
    /// A client certificate with the name as its common name.
    Certificate,
}

impl Entry {
    /// Whom it lets in.
    pub fn name(&self) -> ClientName {
        self.name
    }

    /// What that one may do.
    pub fn role(&self) -> Role {
        self.role
    }

    /// Eight digits that tell it from others of its name; `certificate` for one without a token.
    pub fn id(&self) -> String {
        let digits = self.digest.map(|digest| hexadecimal(&digest));
        let id = digits.as_deref().and_then(|digits| digits.get(..ID));
        id.unwrap_or("certificate").to_owned()
    }

    /// When it was made, as the file says.
    pub fn created(&self) -> &str {
        &self.created
    }

    fn parse(written: Written) -> Result<Self, String> {
        let Written {
            name,
            role,
            sha256,
            created,
        } = written;
        let wrong = |error| format!("name \"{}\": {error}", name.escape_debug());
        let name: ClientName = name.parse().map_err(wrong)?;
        let digest = |text: String| {
            digest_of(&text)
                .ok_or_else(|| format!("`{name}`: sha256 must be 64 hexadecimal digits"))
        };
        let digest = sha256.map(digest).transpose()?;
        Ok(Self {
            name,
            role,
            digest,
            created,
        })
    }

    fn written(&self) -> Written {
        Written {
            name: self.name.to_string(),
            role: self.role,
            sha256: self.digest.map(|digest| hexadecimal(&digest)),
            created: self.created.clone(),
        }
    }
}

impl TokenFile {
    /// The file at `path`, which must be there.
    ///
    /// # Errors
    /// [`AccessError`] with the entry that is wrong.
    pub fn read(path: &Path) -> Result<Self, AccessError> {
        let text = files::read(path, LONGEST_FILE)?;
        Self::parse(&text).map_err(|why| AccessError::new(path, why))
    }

    /// As [`Self::read`]; empty where there is no file yet.
    ///
    /// # Errors
    /// [`AccessError`] with the entry that is wrong.
    pub fn read_or_new(path: &Path) -> Result<Self, AccessError> {
        if path.exists() {
            Self::read(path)
        } else {
            Ok(Self::default())
        }
    }

    fn parse(text: &str) -> Result<Self, String> {
        let file: WrittenFile = toml::from_str(text).map_err(|error| error.to_string())?;
        let entries: Result<Vec<_>, _> = file.token.into_iter().map(Entry::parse).collect();
        Ok(Self { entries: entries? })
    }

    /// Writes the file whole or not at all, readable by its owner only.
    ///
    /// # Errors
    /// [`AccessError`] when the system refuses.
    pub fn write(&self, path: &Path) -> Result<(), AccessError> {
        let token = self.entries.iter().map(Entry::written).collect();
        let text = toml::to_string(&WrittenFile { token });
        let text = text.map_err(|error| AccessError::new(path, error))?;
        files::write_private(path, text.as_bytes())
    }

    /// All entries, in the order of the file.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Adds an entry; the token of a new bearer, which is nowhere else afterwards.
    ///
    /// # Errors
    /// When the system has no random numbers.
    pub fn add(
        &mut self,
        name: ClientName,
        role: Role,
        proof: NewToken,
    ) -> Result<Option<String>, String> {
        let token = match proof {
            NewToken::Bearer => Some(new_token()?),
            NewToken::Certificate => None,
        };
        let created = prost_types::Timestamp::from(SystemTime::now());
        self.entries.push(Entry {
            name,
            role,
            digest: token.as_deref().map(|token| Sha256::digest(token).into()),
            created: prost_types::Timestamp {
                nanos: 0,
                ..created
            }
            .to_string(),
        });
        Ok(token)
    }

    /// Removes the entries of a name, or the one with that `id`; how many.
    pub fn revoke(&mut self, name: ClientName, id: Option<&str>) -> usize {
        let before = self.entries.len();
        let is_it = |entry: &Entry| entry.name == name && id.is_none_or(|id| entry.id() == id);
        self.entries.retain(|entry| !is_it(entry));
        before - self.entries.len()
    }

    /// The entry of a token.
    pub(super) fn of_token(&self, token: &str) -> Option<&Entry> {
        if token.len() > LONGEST {
            return None;
        }
        let presented: Digest256 = Sha256::digest(token).into();
        let mut found = u64::MAX;
        for (place, entry) in (0..).zip(&self.entries) {
            // One without a token is compared with what no digest is known to be.
            let digest = entry.digest.unwrap_or_default();
            let is_it = digest.ct_eq(&presented) & u8::from(entry.digest.is_some()).ct_eq(&1);
            found.conditional_assign(&place, is_it);
        }
        self.entries.get(usize::try_from(found).ok()?)
    }

    /// The entry of a certificate's common name.
    pub(super) fn of_certificate(&self, name: ClientName) -> Option<&Entry> {
        let mut certificates = self.entries.iter().filter(|entry| entry.digest.is_none());
        certificates.find(|entry| entry.name == name)
    }

    /// Whether an entry still stands as it was.
    pub(super) fn has(&self, entry: &Entry) -> bool {
        self.entries.contains(entry)
    }
}

fn new_token() -> Result<String, String> {
    let mut secret = [0; SECRET];
    let random = ring::default_provider().secure_random;
    let filled = random.fill(&mut secret);
    filled.map_err(|_| "the system has no random numbers".to_owned())?;
    Ok(format!("{PREFIX}{}", hexadecimal(&secret)))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn digest_of(text: &str) -> Option<Digest256> {
    let mut digest = Digest256::default();
    let (pairs, rest) = text.as_bytes().as_chunks::<2>();
    if pairs.len() != digest.len() || !rest.is_empty() {
        return None;
    }
    for (byte, pair) in digest.iter_mut().zip(pairs) {
        let [high, low] = pair.map(|digit| char::from(digit).to_digit(16));
        *byte = u8::try_from(high? * 16 + low?).ok()?;
    }
    Some(digest)
}

#[cfg(test)]
mod tests;
