//! The lines of an Abaqus file: keywords with parameters, data, comments.
//!
//! A keyword line begins with one star; it goes on in the next line when it ends with a
//! comma. Two stars begin a comment. Words know no case, and blanks between the commas
//! no meaning. Cost: one pass.

use super::error::{InpError, InpFault};

/// A keyword line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Keyword {
    /// In capitals, with single blanks.
    pub(super) name: String,
    /// Where it stands.
    pub(super) line: usize,
    /// Bytes of the file before it.
    pub(super) start: usize,
    /// Names in capitals, and values as they are written, without quotes.
    parameters: Vec<(String, Option<String>)>,
}

impl Keyword {
    /// Whether a parameter is there, with a value or without.
    pub(super) fn has(&self, name: &str) -> bool {
        self.parameters.iter().any(|(found, _)| found == name)
    }

    /// The value of a parameter.
    pub(super) fn value(&self, name: &str) -> Option<&str> {
        let found = self.parameters.iter().find(|(found, _)| found == name);
        found.and_then(|(_, value)| value.as_deref())
    }

    /// The value of a parameter that must be there.
    pub(super) fn required(&self, name: &'static str) -> Result<&str, InpError> {
        let value = self.value(name).filter(|value| !value.is_empty());
        value.ok_or_else(|| self.error(InpFault::MissingParameter(name)))
    }

    /// A fault of this line.
    pub(super) fn error(&self, fault: InpFault) -> InpError {
        self.error_at(self.line, fault)
    }

    /// A fault of one of its data lines.
    pub(super) fn error_at(&self, line: usize, fault: InpFault) -> InpError {
        InpError {
            file: None,
            line: Some(line),
            keyword: Some(self.name.clone()),
            fault,
        }
    }
}

/// A data line: what stands between its commas, without blanks around it.
pub(super) struct Data<'a> {
    pub(super) line: usize,
    pub(super) fields: Vec<&'a [u8]>,
}

/// The lines of a file, one after another.
pub(super) struct Cards<'a> {
    rest: &'a [u8],
    /// Bytes of the whole.
    length: usize,
    /// Lines taken.
    pub(super) line: usize,
}

impl<'a> Cards<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            rest: bytes,
            length: bytes.len(),
            line: 0,
        }
    }

    /// The next line that is no comment, and is not empty, without taking it.
    fn peek(&mut self) -> Option<&'a [u8]> {
        loop {
            let length = self.rest.iter().position(|byte| *byte == b'\n');
            let length = length.unwrap_or(self.rest.len());
            let line = self.rest.get(..length)?.trim_ascii();
            if self.rest.is_empty() {
                return None;
            }
            if !line.is_empty() && !line.starts_with(b"**") {
                return Some(line);
            }
            self.take();
        }
    }

    fn take(&mut self) {
        let length = self.rest.iter().position(|byte| *byte == b'\n');
        let next = length.map_or(self.rest.len(), |length| length + 1);
        self.rest = self.rest.get(next..).unwrap_or_default();
        self.line += 1;
    }

    /// Bytes taken.
    pub(super) fn taken(&self) -> usize {
        self.length - self.rest.len()
    }

    /// Whether the next line begins with a word.
    pub(super) fn begins_with(&mut self, word: &[u8]) -> bool {
        let line = self.peek();
        let start = line.and_then(|line| line.get(..word.len()));
        start.is_some_and(|start| start.eq_ignore_ascii_case(word))
    }

    /// The next data line of the keyword that was read last.
    pub(super) fn data(&mut self) -> Option<Data<'a>> {
        let line = self.peek().filter(|line| !line.starts_with(b"*"))?;
        self.take();
        let mut fields: Vec<&[u8]> = line.split(|byte| *byte == b',').collect();
        fields
            .iter_mut()
            .for_each(|field| *field = field.trim_ascii());
        while fields.last().is_some_and(|field| field.is_empty()) {
            fields.pop();
        }
        Some(Data {
            line: self.line,
            fields,
        })
    }

    /// The next keyword, whatever stands before it.
    pub(super) fn keyword(&mut self) -> Option<Keyword> {
        while self.peek().is_some_and(|line| !line.starts_with(b"*")) {
            self.take();
        }
        let first = self.peek()?;
        let start = self.taken();
        self.take();
        let line = self.line;
        let mut words = first.get(1..).unwrap_or_default().to_vec();
        while words.ends_with(b",") {
            match self.peek().filter(|next| !next.starts_with(b"*")) {
                Some(next) => words.extend(next),
                None => break,
            }
            self.take();
        }
        let mut parts = words.split(|byte| *byte == b',');
        let name = capitals(parts.next().unwrap_or_default());
        Some(Keyword {
            name,
            line,
            start,
            parameters: parts.map(parameter).collect(),
        })
    }
}

fn parameter(part: &[u8]) -> (String, Option<String>) {
    match part.iter().position(|byte| *byte == b'=') {
        Some(at) => {
            let (name, value) = part.split_at(at);
            let value = text(value.get(1..).unwrap_or_default());
            (capitals(name), Some(value))
        }
        None => (capitals(part), None),
    }
}

/// A name as it is written, without blanks or quotes around it.
pub(super) fn text(bytes: &[u8]) -> String {
    let bytes = bytes.trim_ascii();
    let quoted = bytes
        .strip_prefix(b"\"")
        .and_then(|rest| rest.strip_suffix(b"\""));
    String::from_utf8_lossy(quoted.unwrap_or(bytes)).into_owned()
}

/// In capitals, with single blanks.
fn capitals(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes).to_ascii_uppercase();
    let words: Vec<&str> = text.split_whitespace().collect();
    words.join(" ")
}

/// The first characters of what was found, fit for a message.
pub(super) fn excerpt(bytes: &[u8]) -> String {
    let head = bytes.get(..24).unwrap_or(bytes);
    format!("\"{}\"", head.escape_ascii())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keywords_go_on_after_a_comma_and_comments_are_left_out() {
        let text = b"** made by hand\n 1, 2\n*element, TYPE = c3d4,\r\n elset=\"My Set\"\n\
                     1, 2,\n** more\n\n 3, x,, \n*End  Part\n";
        let mut cards = Cards::new(text);
        let keyword = cards.keyword().unwrap();
        assert_eq!((keyword.name.as_str(), keyword.line), ("ELEMENT", 3));
        assert_eq!(keyword.value("TYPE"), Some("c3d4"));
        assert_eq!(keyword.value("ELSET"), Some("My Set"));
        let data = cards.data().unwrap();
        assert_eq!((data.line, data.fields), (5, vec![&b"1"[..], b"2"]));
        assert_eq!(cards.data().unwrap().fields, [&b"3"[..], b"x"]);
        assert!(cards.data().is_none());
        assert_eq!(cards.keyword().unwrap().name, "END PART");
        assert!(cards.keyword().is_none());
    }
}
