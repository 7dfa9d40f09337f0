//! Cases from a table: a CSV file (RFC 4180) whose first line names keys of the scene.
//!
//! The bytes of the file are kept as they are, with the place of every 64th row, so that a
//! row is found without a list of all. A cell is read as `--set` reads a value; an empty one
//! leaves the key as the scene has it.

use csv::{ByteRecord, Reader, ReaderBuilder};
use toml::Value;

use crate::scene_file::read_value;

/// Rows between two places that are known.
const STRIDE: u64 = 64;

/// A table of cases.
#[derive(Clone, Debug)]
pub(crate) struct List {
    pub(crate) keys: Vec<String>,
    bytes: Vec<u8>,
    /// Offsets of the rows 0, 64, 128, ...
    places: Vec<usize>,
    pub(crate) rows: u64,
    /// Of each column, whether every cell is a number.
    pub(crate) numeric: Vec<bool>,
}

/// What is wrong with a table, and in which line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ListFault {
    pub(crate) line: u64,
    pub(crate) message: String,
}

fn fault(line: u64, message: impl Into<String>) -> ListFault {
    let message = message.into();
    ListFault { line, message }
}

impl List {
    /// Reads the table once, row by row.
    pub(crate) fn read(bytes: Vec<u8>) -> Result<Self, ListFault> {
        let mut list = Self {
            keys: Vec::new(),
            bytes: Vec::new(),
            places: Vec::new(),
            rows: 0,
            numeric: Vec::new(),
        };
        let mut reader = rows_of(&bytes);
        let mut record = ByteRecord::new();
        if !next(&mut reader, &mut record)? {
            return Err(fault(1, "the file is empty; its first line names keys"));
        }
        list.header(&record)?;
        loop {
            let place = reader.position().byte();
            if !next(&mut reader, &mut record)? {
                break;
            }
            list.row(&record, place)?;
        }
        match list.rows {
            0 => Err(fault(2, "there is no row below the line of keys")),
            _ => Ok(Self { bytes, ..list }),
        }
    }

    fn header(&mut self, record: &ByteRecord) -> Result<(), ListFault> {
        for (cell, column) in record.iter().zip(1..) {
            let key = text(cell, record)?.trim().to_owned();
            if key.is_empty() {
                return Err(fault(1, format!("column {column} has no key above it")));
            }
            self.keys.push(key);
        }
        self.numeric = vec![true; self.keys.len()];
        Ok(())
    }

    fn row(&mut self, record: &ByteRecord, place: u64) -> Result<(), ListFault> {
        for (cell, numeric) in record.iter().zip(&mut self.numeric) {
            let cell = text(cell, record)?;
            *numeric &= cell.trim().is_empty() || cell.trim().parse::<f64>().is_ok();
        }
        if self.rows.is_multiple_of(STRIDE) {
            self.places
                .push(usize::try_from(place).unwrap_or(usize::MAX));
        }
        self.rows += 1;
        Ok(())
    }

    /// Adds its bytes to a digest.
    pub(crate) fn hash(&self, hash: &mut impl sha2::Digest) {
        hash.update(&self.bytes);
    }

    /// The cells of a row; none beyond the last.
    pub(crate) fn cells(&self, row: u64) -> Vec<Option<Value>> {
        let stride = usize::try_from(row / STRIDE).unwrap_or(usize::MAX);
        let place = self.places.get(stride).copied();
        let from = place
            .and_then(|place| self.bytes.get(place..))
            .unwrap_or_default();
        let mut reader = rows_of(from);
        let mut record = ByteRecord::new();
        for _ in 0..=row % STRIDE {
            // Read before, so it can be read again.
            if !next(&mut reader, &mut record).unwrap_or(false) {
                return Vec::new();
            }
        }
        record
            .iter()
            .map(|cell| value(&String::from_utf8_lossy(cell)))
            .collect()
    }
}

fn rows_of(bytes: &[u8]) -> Reader<&[u8]> {
    ReaderBuilder::new().has_headers(false).from_reader(bytes)
}

fn next(reader: &mut Reader<&[u8]>, record: &mut ByteRecord) -> Result<bool, ListFault> {
    reader.read_byte_record(record).map_err(|error| {
        let line = error.position().map_or(0, csv::Position::line);
        if let csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } = error.kind()
        {
            return fault(line, format!("has {len} cells below {expected_len} keys"));
        }
        fault(line, error.to_string())
    })
}

fn text<'a>(cell: &'a [u8], record: &ByteRecord) -> Result<&'a str, ListFault> {
    let line = record.position().map_or(0, csv::Position::line);
    std::str::from_utf8(cell).map_err(|_| fault(line, "is not UTF-8"))
}

fn value(cell: &str) -> Option<Value> {
    (!cell.trim().is_empty()).then(|| read_value(cell))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(text: &str) -> Result<List, ListFault> {
        List::read(text.as_bytes().to_vec())
    }

    #[test]
    fn cells_are_values_as_of_set_and_an_empty_one_is_none() {
        let list =
            list("\u{feff}a.b,c,d\r\n1,\"[1, 2]\",\"say \"\"so\"\"\"\r\n,2.5,true\r\n").unwrap();
        assert_eq!(list.keys, ["a.b", "c", "d"]);
        assert_eq!(
            (list.rows, list.numeric.as_slice()),
            (2, &[true, false, false][..])
        );
        let first = list.cells(0);
        assert_eq!(first[0], Some(Value::Integer(1)));
        assert_eq!(
            first[1].as_ref().and_then(Value::as_array).map(Vec::len),
            Some(2)
        );
        assert_eq!(first[2], Some(Value::String("say \"so\"".to_owned())));
        assert_eq!(list.cells(1)[0], None);
        assert!(list.cells(2).is_empty());
    }

    #[test]
    fn every_row_is_found_again() {
        let rows: String = (0..1000)
            .map(|row| format!("{row},\"line\nof {row}\"\n"))
            .collect();
        let list = list(&format!("x,name\n{rows}")).unwrap();
        assert_eq!(list.rows, 1000);
        for row in [0, 1, 63, 64, 65, 640, 999] {
            assert_eq!(list.cells(row)[0], Some(Value::Integer(row as i64)));
        }
    }

    #[test]
    fn faults_name_their_line() {
        for (text, line, word) in [
            ("", 1, "empty"),
            ("a,b\n", 2, "no row"),
            ("a,\n1,2\n", 1, "column 2"),
            ("a,b\n1,2\n3\n", 3, "1 cells below 2 keys"),
        ] {
            let fault = list(text).unwrap_err();
            assert_eq!(fault.line, line, "{text:?}: {fault:?}");
            assert!(fault.message.contains(word), "{text:?}: {fault:?}");
        }
        let wrong = List::read(b"a\n1\n\xff\n".to_vec()).unwrap_err();
        assert_eq!((wrong.line, wrong.message.as_str()), (3, "is not UTF-8"));
    }
}
