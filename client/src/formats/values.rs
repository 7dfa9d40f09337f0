//! Values of another code, as text: one row a node, facet or cell.
//!
//! ```text
//! # comments, anywhere
//! node, x, y, z
//! 0, 0.1, 0.0, 0.0
//! 7, 0.2, 0.0, 0.0
//! ```
//!
//! Columns stand between commas or spaces. The first line says what the rows belong to: `node`,
//! `facet` or `cell`; it may begin with `#`, as `numpy.savetxt` writes it. Numbers are from 0: of
//! nodes in the order of the results, vertices of the mesh and then the middles of edges; of
//! facets and cells in the order of the mesh. That all are there is for the service to say.
//! Cost: one pass.

use std::collections::HashMap;

use signorini_proto::array;
use signorini_proto::v1;

/// Most rows of a file; a message of the service takes fewer.
const MOST_ROWS: usize = 1 << 20;
/// Most bytes of a file.
pub const MOST_BYTES: u64 = 128 << 20;

/// Words for what rows belong to.
const PLACES: [(&str, v1::ValuePlace); 3] = [
    ("node", v1::ValuePlace::Nodes),
    ("facet", v1::ValuePlace::Facets),
    ("cell", v1::ValuePlace::Cells),
];

/// The rows of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ValuesFile {
    /// What they belong to.
    pub place: v1::ValuePlace,
    /// Number of the node, facet or cell of each row, each once.
    pub numbers: Vec<i32>,
    /// The values.
    pub rows: Vec<[f64; 3]>,
}

/// Why a file has no values.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ValuesFileError {
    /// Bytes that are no text.
    #[error("is not a text: values are a line `node, x, y, z` and one line a node")]
    NotText,
    /// Another first line.
    #[error(
        "line {line}: `node, x, y, z` is expected first, or `facet`, or `cell`, found \"{found}\""
    )]
    Header {
        /// From 1.
        line: usize,
        /// The beginning of what is there.
        found: String,
    },
    /// A file without a first line.
    #[error("is empty: a line `node, x, y, z` is expected first")]
    Empty,
    /// More or less than four columns.
    #[error("line {line}: a number and three values are expected, found {found} columns")]
    Columns {
        /// From 1.
        line: usize,
        /// Columns that are there.
        found: usize,
    },
    /// A word that is no number of a node, facet or cell.
    #[error("line {line}: the number of a {what} is expected, found \"{found}\"")]
    Number {
        /// From 1.
        line: usize,
        /// Node, facet or cell.
        what: &'static str,
        /// The beginning of what is there.
        found: String,
    },
    /// A word that is no finite number.
    #[error("line {line}: {what} {number}: a finite number is expected, found \"{found}\"")]
    Value {
        /// From 1.
        line: usize,
        /// Node, facet or cell.
        what: &'static str,
        /// Its number.
        number: i32,
        /// The beginning of what is there.
        found: String,
    },
    /// Two rows for one.
    #[error("line {line}: {what} {number} has a row already, in line {before}")]
    Twice {
        /// From 1.
        line: usize,
        /// Node, facet or cell.
        what: &'static str,
        /// Its number.
        number: i32,
        /// The line of the other row.
        before: usize,
    },
    /// More rows than are taken.
    #[error("line {line}: more than {MOST_ROWS} rows")]
    TooLarge {
        /// From 1.
        line: usize,
    },
}

/// Reads a file.
///
/// # Errors
/// [`ValuesFileError`] with the line, and the node where there is one.
pub fn read(bytes: &[u8]) -> Result<ValuesFile, ValuesFileError> {
    let text = std::str::from_utf8(bytes).map_err(|_| ValuesFileError::NotText)?;
    let mut reader: Option<Reader> = None;
    for (index, text) in text.lines().enumerate() {
        let line = index + 1;
        match &mut reader {
            Some(reader) => reader.line(line, words(text.split('#').next().unwrap_or_default()))?,
            None => reader = header(line, text)?,
        }
    }
    reader.map(|one| one.file).ok_or(ValuesFileError::Empty)
}

/// Columns of a line.
fn words(text: &str) -> Vec<&str> {
    let between = |letter: char| letter == ',' || letter.is_ascii_whitespace();
    text.split(between)
        .filter(|word| !word.is_empty())
        .collect()
}

/// What rows belong to; none for a comment and an empty line.
fn header(line: usize, text: &str) -> Result<Option<Reader>, ValuesFileError> {
    let bare = text.trim_start().trim_start_matches('#');
    let found = words(bare);
    for (what, place) in PLACES {
        if found == [what, "x", "y", "z"] {
            return Ok(Some(Reader::new(what, place)));
        }
    }
    if words(text.split('#').next().unwrap_or_default()).is_empty() {
        Ok(None)
    } else {
        Err(ValuesFileError::Header {
            line,
            found: shown(text),
        })
    }
}

/// The beginning of a text.
fn shown(text: &str) -> String {
    text.chars()
        .take(20)
        .filter(|one| !one.is_control())
        .collect()
}

struct Reader {
    what: &'static str,
    file: ValuesFile,
    /// Line of each number.
    lines: HashMap<i32, usize>,
}

impl Reader {
    fn new(what: &'static str, place: v1::ValuePlace) -> Self {
        Self {
            what,
            file: ValuesFile {
                place,
                numbers: Vec::new(),
                rows: Vec::new(),
            },
            lines: HashMap::new(),
        }
    }

    fn line(&mut self, line: usize, words: Vec<&str>) -> Result<(), ValuesFileError> {
        let what = self.what;
        let [number, values @ ..] = &words[..] else {
            return Ok(());
        };
        let values: [&str; 3] = values.try_into().map_err(|_| ValuesFileError::Columns {
            line,
            found: words.len(),
        })?;
        let read = number.parse::<i32>().ok().filter(|number| *number >= 0);
        let number = read.ok_or_else(|| ValuesFileError::Number {
            line,
            what,
            found: shown(number),
        })?;
        let mut row = [0.0; 3];
        for (slot, word) in row.iter_mut().zip(values) {
            let value = word.parse::<f64>().ok().filter(|value| value.is_finite());
            *slot = value.ok_or_else(|| ValuesFileError::Value {
                line,
                what,
                number,
                found: shown(word),
            })?;
        }
        if let Some(before) = self.lines.insert(number, line) {
            return Err(ValuesFileError::Twice {
                line,
                what,
                number,
                before,
            });
        }
        if self.file.rows.len() == MOST_ROWS {
            return Err(ValuesFileError::TooLarge { line });
        }
        self.file.numbers.push(number);
        self.file.rows.push(row);
        Ok(())
    }
}

impl ValuesFile {
    /// The message.
    pub fn to_wire(&self) -> v1::Values {
        v1::Values {
            place: self.place.into(),
            numbers: array::encode(&self.numbers),
            rows: array::encode(self.rows.as_flattened()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "# of the fluid\n\nnode, x, y, z\n7, 1, -2.5, 3e-1\n 0 0 0 0 # at rest\n";

    #[test]
    fn rows_are_read_with_commas_or_spaces() {
        let file = read(GOOD.as_bytes()).expect("values");
        assert_eq!(
            (file.place, &file.numbers[..]),
            (v1::ValuePlace::Nodes, &[7, 0][..])
        );
        assert_eq!(file.rows, [[1.0, -2.5, 0.3], [0.0; 3]]);
        let wire = file.to_wire();
        assert_eq!((wire.numbers.len(), wire.rows.len()), (8, 48));
        let numpy = read(b"# facet x y z\n3.0e0 1 2 3").unwrap_err();
        assert!(matches!(numpy, ValuesFileError::Number { line: 2, .. }));
        let none = read(b"#cell x y z").expect("values without rows");
        assert_eq!((none.place, none.rows.len()), (v1::ValuePlace::Cells, 0));
    }

    #[test]
    fn faults_name_the_line_and_the_node() {
        let of = |change: &str| {
            let text = format!("{GOOD}{change}\n");
            read(text.as_bytes()).unwrap_err().to_string()
        };
        let cases = [
            (
                "1, 2, 3",
                "line 6: a number and three values are expected, found 3 columns",
            ),
            (
                "1, 2, nan, 4",
                "line 6: node 1: a finite number is expected, found \"nan\"",
            ),
            (
                "1, 2, 1e999, 4",
                "line 6: node 1: a finite number is expected, found \"1e999\"",
            ),
            (
                "-1, 2, 3, 4",
                "line 6: the number of a node is expected, found \"-1\"",
            ),
            ("7, 2, 3, 4", "line 6: node 7 has a row already, in line 4"),
        ];
        for (line, expected) in cases {
            assert_eq!(of(line), expected);
        }
        let first = read(b"\n1, 2, 3, 4").unwrap_err().to_string();
        assert!(
            first.starts_with("line 2: `node, x, y, z` is expected first"),
            "{first}"
        );
        assert_eq!(read(b" \n# x"), Err(ValuesFileError::Empty));
        assert_eq!(read(&[0xff]), Err(ValuesFileError::NotText));
    }

    #[test]
    fn any_bytes_are_values_or_refused() {
        let mut random = fastrand::Rng::with_seed(8);
        for _ in 0..30_000 {
            let mut bytes = GOOD.as_bytes().to_vec();
            for _ in 0..random.usize(1..6) {
                if bytes.is_empty() {
                    break;
                }
                let place = random.usize(..bytes.len());
                match random.u8(..4) {
                    0 => bytes[place] = random.u8(..),
                    1 => bytes.insert(place, *random.choice(b",. \n-e019#").unwrap_or(&0)),
                    2 => drop(bytes.remove(place)),
                    _ => bytes.truncate(place + 1),
                }
            }
            if let Ok(file) = read(&bytes) {
                assert_eq!(file.numbers.len(), file.rows.len());
                assert!(
                    file.rows
                        .as_flattened()
                        .iter()
                        .all(|value| value.is_finite())
                );
            }
        }
    }
}
