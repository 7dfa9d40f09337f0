//! Reads values one after another from the bytes of a mesh file, in either
//! encoding.
//!
//! Every read is bounds-checked and names what it looked for. Line numbers are
//! counted only when an error is made, so reading costs one pass.

use super::error::{Fault, MshError, Position};

/// How numbers are written inside sections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Decimal text separated by blanks.
    Text,
    /// Little-endian `i32`, `u64` and `f64`.
    Binary,
}

/// A position in the bytes of a file.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    section: Option<String>,
    encoding: Encoding,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            section: None,
            encoding: Encoding::Text,
        }
    }

    pub(super) fn encoding(&self) -> Encoding {
        self.encoding
    }

    pub(super) fn set_encoding(&mut self, encoding: Encoding) {
        self.encoding = encoding;
    }

    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    /// An error at the current place.
    pub(super) fn error(&self, fault: Fault) -> MshError {
        self.error_at(self.at, fault)
    }

    fn error_at(&self, at: usize, fault: Fault) -> MshError {
        let position = match self.encoding {
            Encoding::Binary => Position::Byte(at),
            Encoding::Text => Position::Line(line_of(self.bytes, at)),
        };
        MshError {
            section: self.section.clone(),
            position: Some(position),
            fault,
        }
    }

    /// Moves past blanks; false at the end of the file.
    fn skip_blanks(&mut self) -> bool {
        let blanks = self
            .rest()
            .iter()
            .take_while(|byte| byte.is_ascii_whitespace());
        self.at += blanks.count();
        self.at < self.bytes.len()
    }

    /// The next run of characters without blanks.
    fn token(&mut self, expected: &'static str) -> Result<&'a [u8], MshError> {
        if !self.skip_blanks() {
            return Err(self.error(Fault::Truncated(expected)));
        }
        let rest = self.rest();
        let length = rest
            .iter()
            .take_while(|byte| !byte.is_ascii_whitespace())
            .count();
        self.at += length;
        Ok(rest.get(..length).unwrap_or_default())
    }

    fn parse<T: std::str::FromStr>(&mut self, expected: &'static str) -> Result<T, MshError> {
        let token = self.token(expected)?;
        let text = std::str::from_utf8(token).ok();
        text.and_then(|text| text.parse().ok()).ok_or_else(|| {
            let found = excerpt(token);
            self.error_at(self.at - token.len(), Fault::Unexpected { expected, found })
        })
    }

    fn take<const N: usize>(&mut self, expected: &'static str) -> Result<[u8; N], MshError> {
        let taken = self.rest().first_chunk::<N>().copied();
        let taken = taken.ok_or_else(|| self.error(Fault::Truncated(expected)))?;
        self.at += N;
        Ok(taken)
    }

    /// A word of text, whatever the encoding of numbers.
    pub(super) fn word(&mut self, expected: &'static str) -> Result<String, MshError> {
        self.token(expected)
            .map(|token| String::from_utf8_lossy(token).into_owned())
    }

    /// A text integer, whatever the encoding of numbers.
    pub(super) fn text_integer(&mut self, expected: &'static str) -> Result<i64, MshError> {
        self.parse(expected)
    }

    /// A signed integer: tags and dimensions.
    pub(super) fn integer(&mut self, expected: &'static str) -> Result<i64, MshError> {
        match self.encoding {
            Encoding::Text => self.parse(expected),
            Encoding::Binary => self
                .take(expected)
                .map(|bytes| i64::from(i32::from_le_bytes(bytes))),
        }
    }

    /// The number of a physical group: the sign of a tag only tells a direction.
    pub(super) fn group_number(&self, tag: i64) -> Result<i64, MshError> {
        tag.checked_abs().ok_or_else(|| {
            let (expected, found) = ("a physical group", tag.to_string());
            self.error(Fault::Unexpected { expected, found })
        })
    }

    /// An unsigned integer of pointer size: counts and numbers of MSH 4.1.
    pub(super) fn size(&mut self, expected: &'static str) -> Result<u64, MshError> {
        match self.encoding {
            Encoding::Text => self.parse(expected),
            Encoding::Binary => self.take(expected).map(u64::from_le_bytes),
        }
    }

    /// A number that must not be negative: counts and numbers of MSH 2.2.
    pub(super) fn natural(&mut self, expected: &'static str) -> Result<u64, MshError> {
        let start = self.at;
        let value = self.integer(expected)?;
        u64::try_from(value).map_err(|_| {
            let found = value.to_string();
            self.error_at(start, Fault::Unexpected { expected, found })
        })
    }

    /// A real number.
    pub(super) fn real(&mut self, expected: &'static str) -> Result<f64, MshError> {
        match self.encoding {
            Encoding::Text => self.parse(expected),
            Encoding::Binary => self.take(expected).map(f64::from_le_bytes),
        }
    }

    /// Three real numbers.
    pub(super) fn point(&mut self) -> Result<[f64; 3], MshError> {
        let expected = "a coordinate";
        Ok([
            self.real(expected)?,
            self.real(expected)?,
            self.real(expected)?,
        ])
    }

    /// Checks a declared count against what the rest of the file can hold, each
    /// item taking at least `integers` values.
    pub(super) fn bounded(
        &self,
        what: &'static str,
        declared: u64,
        integers: usize,
    ) -> Result<usize, MshError> {
        let smallest = match self.encoding {
            // One digit and one blank; the last blank may be missing.
            Encoding::Text => 2,
            Encoding::Binary => 4,
        };
        let remaining = self.rest().len();
        let most = (remaining + 1) / (smallest * integers.max(1));
        usize::try_from(declared)
            .ok()
            .filter(|count| *count <= most)
            .ok_or_else(|| {
                self.error(Fault::Count {
                    what,
                    declared,
                    remaining,
                })
            })
    }

    /// A text between double quotes.
    pub(super) fn quoted(&mut self, expected: &'static str) -> Result<String, MshError> {
        if !self.skip_blanks() {
            return Err(self.error(Fault::Truncated(expected)));
        }
        let found = || excerpt(self.rest());
        let rest = self.rest().strip_prefix(b"\"");
        let rest = rest.ok_or_else(|| {
            self.error(Fault::Unexpected {
                expected,
                found: found(),
            })
        })?;
        let length = rest.iter().position(|byte| matches!(byte, b'"' | b'\n'));
        let length = length.ok_or_else(|| self.error(Fault::Truncated("a closing quote")))?;
        let name = rest.get(..length).unwrap_or_default();
        let name = std::str::from_utf8(name).map_err(|_| {
            self.error(Fault::Unexpected {
                expected,
                found: excerpt(name),
            })
        })?;
        self.at += length + 2;
        Ok(name.to_owned())
    }

    /// Enters the next section; none at the end of the file.
    pub(super) fn open_section(&mut self) -> Result<Option<String>, MshError> {
        self.section = None;
        if !self.skip_blanks() {
            return Ok(None);
        }
        let start = self.at;
        let line = self.line();
        let name = line
            .strip_prefix(b"$")
            .and_then(|name| std::str::from_utf8(name).ok());
        let Some(name) = name.map(str::trim_end).filter(|name| !name.is_empty()) else {
            let (expected, found) = ("a section ($Name)", excerpt(line));
            return Err(self.error_at(start, Fault::Unexpected { expected, found }));
        };
        self.section = Some(name.to_owned());
        Ok(Some(name.to_owned()))
    }

    /// The rest of the line, the cursor after its newline.
    fn line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let length = rest
            .iter()
            .position(|byte| *byte == b'\n')
            .unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        rest.get(..length).unwrap_or_default()
    }

    /// Moves after the line in which binary data is announced.
    pub(super) fn end_line(&mut self) {
        self.line();
    }

    /// Expects `$EndName` of the open section.
    pub(super) fn close_section(&mut self) -> Result<(), MshError> {
        let section = self.section.clone().unwrap_or_default();
        let start = self.at;
        let token = self.token("the end of the section")?;
        if token.strip_prefix(b"$End") == Some(section.as_bytes()) {
            return Ok(());
        }
        let (expected, found) = ("the end of the section", excerpt(token));
        Err(self.error_at(start, Fault::Unexpected { expected, found }))
    }

    /// Moves after `$EndName` of the open section, whatever stands before it.
    pub(super) fn skip_section(&mut self) -> Result<(), MshError> {
        let section = self.section.clone().unwrap_or_default();
        let end = format!("$End{section}");
        let found = self
            .rest()
            .windows(end.len())
            .position(|window| window == end.as_bytes());
        let found = found.ok_or_else(|| self.error(Fault::Unterminated(section)))?;
        self.at += found + end.len();
        Ok(())
    }
}

fn line_of(bytes: &[u8], at: usize) -> usize {
    let before = bytes.get(..at).unwrap_or(bytes);
    1 + before.iter().filter(|byte| **byte == b'\n').count()
}

/// The first characters of what was found, fit for a message.
fn excerpt(bytes: &[u8]) -> String {
    let head = bytes.get(..24).unwrap_or(bytes);
    format!("\"{}\"", head.escape_ascii())
}
