//! Numbers on a regular grid, as text: heights over x and y, or signed distances in space.
//!
//! ```text
//! # comments, anywhere
//! counts 3 2
//! origin 0 0
//! spacing 0.5 1
//! 0.1 0.2   0.3 0.4   0.5 0.6
//! ```
//!
//! Three keys in any order, then one number a node between spaces or lines, the last axis
//! fastest, as `numpy.savetxt` writes a table. What a surface needs is for the service to say.
//! Cost: one pass.

use std::str::SplitAsciiWhitespace;

/// Most nodes of a grid, as the service has it.
const MOST_NODES: usize = 1 << 24;

/// A grid of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GridFile {
    /// Nodes along two or three axes.
    pub counts: Vec<usize>,
    /// The first node, one coordinate an axis.
    pub origin: Vec<f64>,
    /// Between nodes, one an axis.
    pub spacing: Vec<f64>,
    /// One a node, the last axis fastest.
    pub values: Vec<f64>,
}

/// Why a file is no grid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GridFileError {
    /// Bytes that are no text.
    #[error("is not a text: a grid is `counts`, `origin`, `spacing` and one number a node")]
    NotText,
    /// A word that has no place.
    #[error("line {line}: {expected} is expected, found \"{found}\"")]
    Unexpected {
        /// From 1.
        line: usize,
        /// What belongs there.
        expected: &'static str,
        /// The beginning of what is there.
        found: String,
    },
    /// A key again, or after the numbers.
    #[error("line {line}: `{key}` stands once, and before the numbers")]
    Again {
        /// From 1.
        line: usize,
        /// The key.
        key: &'static str,
    },
    /// A key that is not there before the numbers.
    #[error("`{0}` is missing before the numbers")]
    Missing(&'static str),
    /// Neither a plane nor space.
    #[error("line {line}: `counts` has {axes} numbers: two of heights, three of distances")]
    Axes {
        /// From 1.
        line: usize,
        /// Numbers that are there.
        axes: usize,
    },
    /// A key with more or less numbers than axes.
    #[error("`{key}` has {there} numbers, `counts` has {axes}")]
    OtherAxes {
        /// The key.
        key: &'static str,
        /// Its numbers.
        there: usize,
        /// Those of `counts`.
        axes: usize,
    },
    /// More nodes than are taken.
    #[error("has more than {MOST_NODES} nodes")]
    TooLarge,
    /// Too few or too many numbers.
    #[error("{there} numbers for {nodes} nodes")]
    OtherCount {
        /// Numbers that are there; of too many, up to the first.
        there: usize,
        /// Product of the counts.
        nodes: usize,
    },
}

/// Reads a file.
///
/// # Errors
/// [`GridFileError`] with the line.
pub fn read(bytes: &[u8]) -> Result<GridFile, GridFileError> {
    let text = std::str::from_utf8(bytes).map_err(|_| GridFileError::NotText)?;
    let mut reader = Reader::default();
    for (index, text) in text.lines().enumerate() {
        let data = text.split('#').next().unwrap_or_default();
        reader.line(index + 1, data.split_ascii_whitespace())?;
    }
    reader.finish()
}

#[derive(Default)]
struct Reader {
    grid: GridFile,
    /// Product of the counts, once the first number has come.
    nodes: Option<usize>,
}

impl Reader {
    fn line(
        &mut self,
        line: usize,
        mut words: SplitAsciiWhitespace<'_>,
    ) -> Result<(), GridFileError> {
        match words.clone().next() {
            Some("counts") => {
                words.next();
                self.once(line, "counts")?;
                self.grid.counts = words
                    .map(|word| count(line, word))
                    .collect::<Result<_, _>>()?;
                let axes = self.grid.counts.len();
                match axes {
                    2 | 3 => Ok(()),
                    _ => Err(GridFileError::Axes { line, axes }),
                }
            }
            Some("origin") => {
                words.next();
                self.once(line, "origin")?;
                self.grid.origin = words
                    .map(|word| number(line, word))
                    .collect::<Result<_, _>>()?;
                Ok(())
            }
            Some("spacing") => {
                words.next();
                self.once(line, "spacing")?;
                self.grid.spacing = words
                    .map(|word| number(line, word))
                    .collect::<Result<_, _>>()?;
                Ok(())
            }
            Some(_) => self.values(line, words),
            None => Ok(()),
        }
    }

    /// Refuses a key that is there, or comes after numbers.
    fn once(&self, line: usize, key: &'static str) -> Result<(), GridFileError> {
        let is_there = match key {
            "counts" => !self.grid.counts.is_empty(),
            "origin" => !self.grid.origin.is_empty(),
            _ => !self.grid.spacing.is_empty(),
        };
        if is_there || self.nodes.is_some() {
            Err(GridFileError::Again { line, key })
        } else {
            Ok(())
        }
    }

    fn values(
        &mut self,
        line: usize,
        words: SplitAsciiWhitespace<'_>,
    ) -> Result<(), GridFileError> {
        let mut words = words.peekable();
        if let (None, Some(first)) = (self.nodes, words.peek()) {
            // A wrong key is told before missing ones.
            number(line, first)?;
        }
        let nodes = match self.nodes {
            Some(nodes) => nodes,
            None => self.head()?,
        };
        self.nodes = Some(nodes);
        for word in words {
            let value = number(line, word)?;
            self.grid.values.push(value);
            let there = self.grid.values.len();
            if there > nodes {
                return Err(GridFileError::OtherCount { there, nodes });
            }
        }
        Ok(())
    }

    /// Checks the keys; the number of nodes.
    fn head(&self) -> Result<usize, GridFileError> {
        let axes = self.grid.counts.len();
        if axes == 0 {
            return Err(GridFileError::Missing("counts"));
        }
        for (key, numbers) in [
            ("origin", &self.grid.origin),
            ("spacing", &self.grid.spacing),
        ] {
            let there = numbers.len();
            if there == 0 {
                return Err(GridFileError::Missing(key));
            }
            if there != axes {
                return Err(GridFileError::OtherAxes { key, there, axes });
            }
        }
        let product = |all: usize, count: &usize| all.checked_mul(*count);
        let nodes = self.grid.counts.iter().try_fold(1, product);
        nodes
            .filter(|nodes| *nodes <= MOST_NODES)
            .ok_or(GridFileError::TooLarge)
    }

    fn finish(self) -> Result<GridFile, GridFileError> {
        let nodes = match self.nodes {
            Some(nodes) => nodes,
            None => self.head()?,
        };
        let there = self.grid.values.len();
        if there == nodes {
            Ok(self.grid)
        } else {
            Err(GridFileError::OtherCount { there, nodes })
        }
    }
}

fn count(line: usize, word: &str) -> Result<usize, GridFileError> {
    word.parse().map_err(|_| unexpected(line, "a count", word))
}

/// A finite number.
fn number(line: usize, word: &str) -> Result<f64, GridFileError> {
    let number: Option<f64> = word.parse().ok();
    number.filter(|number| number.is_finite()).ok_or_else(|| {
        unexpected(
            line,
            "`counts`, `origin`, `spacing` or a finite number",
            word,
        )
    })
}

fn unexpected(line: usize, expected: &'static str, found: &str) -> GridFileError {
    GridFileError::Unexpected {
        line,
        expected,
        found: found.chars().take(20).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str =
        "# heights\ncounts 3 2\norigin 0 -1.5\nspacing 0.5 1e0 # m\n0.1 0.2\n0.3 -4e-1 0.5\n0.6\n";

    fn refused(text: &str) -> GridFileError {
        read(text.as_bytes()).unwrap_err()
    }

    #[test]
    fn keys_and_numbers_are_read_wherever_lines_end() {
        let grid = read(SMALL.as_bytes()).unwrap();
        assert_eq!(grid.counts, [3, 2]);
        assert_eq!(grid.origin, [0.0, -1.5]);
        assert_eq!(grid.spacing, [0.5, 1.0]);
        assert_eq!(grid.values, [0.1, 0.2, 0.3, -0.4, 0.5, 0.6]);
        let other = "spacing 0.5 1\r\norigin 0 -1.5\r\ncounts 3 2\r\n0.1 0.2 0.3 -0.4 0.5 0.6";
        assert_eq!(read(other.as_bytes()).unwrap(), grid);
    }

    #[test]
    fn faults_are_told_with_their_line() {
        let with = |from: &str, to: &str| refused(&SMALL.replace(from, to)).to_string();
        assert_eq!(
            with("0.2", "0,2"),
            "line 5: `counts`, `origin`, `spacing` or a finite number is expected, found \"0,2\""
        );
        assert_eq!(
            with("counts", "count"),
            "line 2: `counts`, `origin`, `spacing` or a finite number is expected, found \"count\""
        );
        assert_eq!(
            with("3 2", "3 -2"),
            "line 2: a count is expected, found \"-2\""
        );
        assert_eq!(
            with("counts 3 2", "counts 3"),
            "line 2: `counts` has 1 numbers: two of heights, three of distances"
        );
        assert_eq!(with("-1.5", ""), "`origin` has 1 numbers, `counts` has 2");
        assert_eq!(
            with("spacing 0.5 1e0", ""),
            "`spacing` is missing before the numbers"
        );
        assert_eq!(
            with("0.6", "origin 0 0"),
            "line 7: `origin` stands once, and before the numbers"
        );
        assert_eq!(with("0.6", ""), "5 numbers for 6 nodes");
        assert_eq!(with("0.6", "0.6 0.7 0.8"), "7 numbers for 6 nodes");
        assert!(with("0.6", "nan").starts_with("line 7: "));
        assert_eq!(with("3 2", "30000 20000"), "has more than 16777216 nodes");
        assert_eq!(
            with("3 2", "9223372036854775807 9223372036854775807"),
            "has more than 16777216 nodes"
        );
        assert_eq!(refused(""), GridFileError::Missing("counts"));
        assert_eq!(read(&[0x80, 0xff]).unwrap_err(), GridFileError::NotText);
    }

    #[test]
    fn thirty_thousand_broken_files_are_read_or_refused() {
        let mut rng = fastrand::Rng::with_seed(9);
        let (mut good, mut bad) = (0, 0);
        for _ in 0..30_000 {
            let mut bytes = SMALL.as_bytes().to_vec();
            for _ in 0..rng.usize(1..4) {
                let place = rng.usize(..bytes.len());
                match rng.u8(..4) {
                    0 => bytes[place] = rng.u8(..),
                    1 => bytes[place] = rng.choice(*b" \n#-.0159e").unwrap_or(b'0'),
                    2 => bytes.insert(place, rng.choice(*b" \n#-.0159e").unwrap_or(b'0')),
                    _ => drop(bytes.remove(place)),
                }
            }
            match read(&bytes) {
                Ok(grid) => {
                    assert_eq!(grid.values.len(), grid.counts.iter().product::<usize>());
                    assert_eq!(grid.origin.len(), grid.counts.len());
                    good += 1;
                }
                Err(_) => bad += 1,
            }
        }
        assert!(good > 1000 && bad > 1000, "{good} {bad}");
    }
}
