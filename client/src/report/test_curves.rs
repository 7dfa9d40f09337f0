//! Test curves of a material, from a table: a row a point, by the names of its columns.
//!
//! Columns `test`, `stretch` (or `strain`, which is the stretch less one) and `stress`, in any
//! order and among others; commas, semicolons or tabs between them; lines that begin with `#` are
//! left out. Cost: one pass.

use csv::{ReaderBuilder, StringRecord, Trim};
use thiserror::Error;

/// Names of tests, and what else they are called.
const TESTS: [(&str, &[&str]); 3] = [
    ("uniaxial", &["tension", "compression", "simple"]),
    ("planar", &["pure-shear", "pure shear"]),
    ("equibiaxial", &["biaxial"]),
];
/// Most points.
const MOST: usize = 100_000;

/// A point of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// `uniaxial`, `planar` or `equibiaxial`.
    pub(crate) test: &'static str,
    /// Length over undeformed length.
    pub(crate) stretch: f64,
    /// Force over undeformed area.
    pub(crate) stress: f64,
}

/// Why a table has no test curves.
#[derive(Debug, Error)]
pub(crate) enum CurveError {
    #[error("no column \"{0}\" in the first row: columns are test, stretch or strain, stress")]
    Column(&'static str),
    #[error(
        "line {line}: \"{found}\" is no test that is fitted: uniaxial, planar (pure shear) or equibiaxial is expected"
    )]
    Test { line: u64, found: String },
    #[error("line {line}: \"{found}\" is no number, which column {column} holds")]
    Number {
        line: u64,
        column: &'static str,
        found: String,
    },
    #[error("there are no points below the first row")]
    Empty,
    #[error("more than {MOST} points")]
    TooMany,
    #[error(transparent)]
    Table(#[from] csv::Error),
}

/// Places of the columns.
struct Columns {
    test: usize,
    stretch: usize,
    /// What is added to the numbers of that column.
    rest: f64,
    stress: usize,
}

impl Columns {
    fn new(header: &StringRecord) -> Result<Self, CurveError> {
        let place = |name: &str| {
            let mut names = header.iter();
            names.position(|other| {
                other
                    .trim_start_matches('\u{feff}')
                    .eq_ignore_ascii_case(name)
            })
        };
        let (stretch, rest) = match (place("stretch"), place("strain")) {
            (Some(stretch), _) => (stretch, 0.0),
            (None, Some(strain)) => (strain, 1.0),
            (None, None) => return Err(CurveError::Column("stretch")),
        };
        Ok(Self {
            test: place("test").ok_or(CurveError::Column("test"))?,
            stretch,
            rest,
            stress: place("stress").ok_or(CurveError::Column("stress"))?,
        })
    }

    fn point(&self, record: &StringRecord) -> Result<Point, CurveError> {
        let line = record.position().map_or(0, csv::Position::line);
        let text = |column: usize| record.get(column).unwrap_or_default();
        let number = |column: usize, name: &'static str| {
            let value = text(column).parse().ok();
            let finite = value.filter(|value: &f64| value.is_finite());
            finite.ok_or_else(|| CurveError::Number {
                line,
                column: name,
                found: excerpt(text(column)),
            })
        };
        Ok(Point {
            test: test(text(self.test)).ok_or_else(|| CurveError::Test {
                line,
                found: excerpt(text(self.test)),
            })?,
            stretch: self.rest + number(self.stretch, "stretch")?,
            stress: number(self.stress, "stress")?,
        })
    }
}

/// The beginning of a text for a message.
fn excerpt(text: &str) -> String {
    text.chars().take(40).collect()
}

/// The test of that name.
fn test(name: &str) -> Option<&'static str> {
    let is_named = |(own, others): &&(&'static str, &[&str])| {
        let mut all = std::iter::once(own).chain(*others);
        all.any(|other| other.eq_ignore_ascii_case(name))
    };
    TESTS.iter().find(is_named).map(|(own, _)| *own)
}

/// What stands between the columns of the first row that is no comment.
pub(crate) fn delimiter(bytes: &[u8]) -> u8 {
    let mut lines = bytes.split(|byte| *byte == b'\n');
    let first = lines.find(|line| !line.starts_with(b"#") && !line.trim_ascii().is_empty());
    let first = first.unwrap_or_default();
    let found = [b';', b'\t'].into_iter().find(|byte| first.contains(byte));
    found.unwrap_or(b',')
}

/// The points of a table.
///
/// # Errors
/// [`CurveError`], the first one found.
pub(crate) fn read(bytes: &[u8]) -> Result<Vec<Point>, CurveError> {
    let mut reader = ReaderBuilder::new()
        .delimiter(delimiter(bytes))
        .comment(Some(b'#'))
        .trim(Trim::All)
        .from_reader(bytes);
    let columns = Columns::new(reader.headers()?)?;
    let mut points = Vec::new();
    for record in reader.records() {
        if points.len() == MOST {
            return Err(CurveError::TooMany);
        }
        points.push(columns.point(&record?)?);
    }
    if points.is_empty() {
        return Err(CurveError::Empty);
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn columns_are_found_by_their_names_in_any_order() {
        let table = "# rubber A\nstress;other;Strain;test\n0.5;x;0.25;uniaxial\n1;y;1;Pure-shear\n";
        let points = read(table.as_bytes()).unwrap();
        let expected = [("uniaxial", 1.25, 0.5), ("planar", 2.0, 1.0)];
        let expected = expected.map(|(test, stretch, stress)| Point {
            test,
            stretch,
            stress,
        });
        assert_eq!(points, expected);
    }

    #[test]
    fn faults_are_told_with_their_line() {
        let told = |table: &str| read(table.as_bytes()).unwrap_err().to_string();
        assert!(told("stretch,stress\n1,2\n").contains("no column \"test\""));
        assert!(told("test,stretch,stress\nbulge,1,2\n").contains("line 2: \"bulge\" is no test"));
        let number = told("test,stretch,stress\nplanar,1,2\nplanar,one,2\n");
        assert!(number.contains("line 3: \"one\" is no number"), "{number}");
        assert!(told("test,stretch,stress\n").contains("no points"));
        assert!(told("").contains("no column"));
    }

    proptest! {
        #[test]
        fn any_bytes_are_points_or_a_fault(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _outcome = read(&bytes);
            let table = [b"test,stretch,stress\n".to_vec(), bytes].concat();
            let _outcome = read(&table);
        }
    }
}
