//! The name that a token or a certificate proves.

use std::fmt;
use std::str::FromStr;

/// Longest name, bytes.
const LONGEST: usize = 32;

/// 1 to 32 of a-z, A-Z, 0-9, `.`, `_` and `-`, a letter or digit first; small enough to be copied
/// into every share and queue.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ClientName {
    bytes: [u8; LONGEST],
    length: u8,
}

/// A text that is no name of a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a name has 1 to 32 of a-z, A-Z, 0-9, `.`, `_` and `-`, a letter or digit first")]
pub struct ClientNameError;

impl ClientName {
    /// Whom something belongs to whose stored owner this version cannot read: nobody has such
    /// a name, so that only who sees all sees it.
    pub(crate) const UNREADABLE: Self = {
        let mut bytes = [0; LONGEST];
        bytes[0] = b'?';
        Self { bytes, length: 1 }
    };

    /// The name as text.
    pub fn as_str(&self) -> &str {
        let bytes = self.bytes.get(..usize::from(self.length));
        // Only ASCII gets in.
        std::str::from_utf8(bytes.unwrap_or_default()).unwrap_or_default()
    }
}

impl FromStr for ClientName {
    type Err = ClientNameError;

    fn from_str(text: &str) -> Result<Self, ClientNameError> {
        let allowed = |byte: u8| byte.is_ascii_alphanumeric() || b"._-".contains(&byte);
        let first = text.bytes().next().ok_or(ClientNameError)?;
        if !first.is_ascii_alphanumeric() || !text.bytes().all(allowed) {
            return Err(ClientNameError);
        }
        let mut bytes = [0; LONGEST];
        let place = bytes.get_mut(..text.len()).ok_or(ClientNameError)?;
        place.copy_from_slice(text.as_bytes());
        let length = u8::try_from(text.len()).map_err(|_| ClientNameError)?;
        Ok(Self { bytes, length })
    }
}

impl fmt::Display for ClientName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.as_str())
    }
}

impl fmt::Debug for ClientName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), formatter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_kept_as_they_are_or_refused() {
        let longest = "a".repeat(32);
        for good in ["a", "line-1", "Robot.cell_2", &longest] {
            assert_eq!(good.parse::<ClientName>().unwrap().as_str(), good);
        }
        let long = "a".repeat(33);
        for bad in ["", "-a", ".a", "a b", "a/b", "a\n", "\u{e9}", &long] {
            assert_eq!(bad.parse::<ClientName>(), Err(ClientNameError), "{bad}");
        }
        let nobody = ClientName::UNREADABLE.to_string();
        assert_eq!(nobody.parse::<ClientName>(), Err(ClientNameError));
    }
}
