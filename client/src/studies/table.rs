//! The table of a study: one row for each case, in order of the cases, from its log.

mod csv_file;
#[cfg(feature = "parquet")]
mod parquet_file;

use std::fs::File;
use std::io::{BufRead as _, BufReader};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};

use serde_json::Value;
use signorini_client::study::{COLUMNS_AFTER, COLUMNS_BEFORE, Case, Study, cell};

use super::log::row_of;
use super::row::Row;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::whole_file;

/// How a table is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// RFC 4180.
    Csv,
    /// Apache Parquet.
    #[cfg(feature = "parquet")]
    Parquet,
}

/// A column and whether its cells are numbers.
struct Column {
    name: String,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Integer,
    Number,
    Text,
}

/// A cell; empty where there is nothing to tell.
enum Cell {
    Integer(i64),
    Number(f64),
    Text(String),
    Empty,
}

/// Takes the rows of a table.
trait Sink {
    fn row(&mut self, cells: Vec<Cell>) -> std::io::Result<()>;
    fn finish(self: Box<Self>) -> std::io::Result<()>;
}

impl Format {
    /// As the extension of a file says.
    pub(crate) fn of(path: &Path) -> Result<Self, Failure> {
        let extension = path.extension().and_then(|extension| extension.to_str());
        match extension {
            Some("csv") => Ok(Self::Csv),
            #[cfg(feature = "parquet")]
            Some("parquet") => Ok(Self::Parquet),
            #[cfg(not(feature = "parquet"))]
            Some("parquet") => {
                let message = "this build writes no Parquet: build it with `--features parquet`, \
                               or name a file that ends in .csv";
                Err(Failure::new(Exit::Usage, message).about(path))
            }
            _ => {
                let message = "ends in neither .csv nor .parquet";
                Err(Failure::new(Exit::Usage, message).about(path))
            }
        }
    }

    fn sink(self, path: &Path, columns: &[Column]) -> std::io::Result<Box<dyn Sink>> {
        let file = whole_file::begin(path)?;
        match self {
            Self::Csv => Ok(Box::new(csv_file::CsvFile::new(file, columns)?)),
            #[cfg(feature = "parquet")]
            Self::Parquet => Ok(Box::new(parquet_file::ParquetFile::new(file, columns)?)),
        }
    }

    /// Writes the table of the rows that a log has.
    pub(crate) fn write(self, path: &Path, study: &Study, log: &Path) -> Result<(), Failure> {
        let found = Found::read(log, study)?;
        let columns = columns(study, &found.numeric);
        let write = || {
            let mut sink = self.sink(path, &columns)?;
            for index in 0..study.count() {
                if let (Some(row), Some(case)) = (found.row(index)?, study.case(index)) {
                    sink.row(cells(study, &columns, &case, &row))?;
                }
            }
            sink.finish()
        };
        write().map_err(|error| Failure::unwritable(path, &error))
    }
}

/// Where the rows of cases stand in a log, eight bytes each.
struct Found {
    path: PathBuf,
    file: File,
    /// Offset and, from 1, of the line; 0 where a case has none.
    places: Vec<u64>,
    /// Of each value that is wanted, whether all there are are numbers.
    numeric: Vec<bool>,
}

impl Found {
    fn read(path: &Path, study: &Study) -> Result<Self, Failure> {
        let told = |error: std::io::Error| Failure::unreadable(path, &error);
        let file = File::open(path).map_err(told)?;
        let count = usize::try_from(study.count()).unwrap_or(usize::MAX);
        let mut found = Self {
            path: path.to_owned(),
            places: vec![0; count],
            numeric: vec![true; study.wanted().len()],
            file: file.try_clone().map_err(told)?,
        };
        let (mut reader, mut line, mut offset) = (BufReader::new(file), Vec::new(), 0_u64);
        loop {
            line.clear();
            let read = reader.read_until(b'\n', &mut line).map_err(told)?;
            if read == 0 {
                return Ok(found);
            }
            if let Some(row) = row_of(&line) {
                found.note(&row, offset);
            }
            offset += read as u64;
        }
    }

    fn note(&mut self, row: &Row, offset: u64) {
        let place = usize::try_from(row.case).ok();
        // The first row of a case counts, as for the log itself.
        match place.and_then(|at| self.places.get_mut(at)) {
            Some(place) if *place == 0 => *place = offset + 1,
            Some(_) | None => return,
        }
        for (value, numeric) in row.results.iter().zip(&mut self.numeric) {
            *numeric &= value.is_number() || value.is_null();
        }
    }

    fn row(&self, index: u64) -> std::io::Result<Option<Row>> {
        let place = usize::try_from(index)
            .ok()
            .and_then(|at| self.places.get(at));
        let Some(offset) = place.and_then(|place| place.checked_sub(1)) else {
            return Ok(None);
        };
        let mut reader = BufReader::with_capacity(1024, At(&self.file, offset));
        let mut line = Vec::new();
        reader.read_until(b'\n', &mut line)?;
        let row = row_of(&line).ok_or_else(|| {
            let message = format!("{} was changed meanwhile", self.path.display());
            std::io::Error::new(std::io::ErrorKind::InvalidData, message)
        });
        row.map(Some)
    }
}

/// A file from an offset on.
struct At<'a>(&'a File, u64);

impl std::io::Read for At<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.0.read_at(buffer, self.1)?;
        self.1 += read as u64;
        Ok(read)
    }
}

fn columns(study: &Study, numeric: &[bool]) -> Vec<Column> {
    let column = |name: &str, kind| Column {
        name: name.to_owned(),
        kind,
    };
    let number = |is_number: bool| if is_number { Kind::Number } else { Kind::Text };
    let fixed = |name: &'static str| {
        let kind = match name {
            "case" | "attempts" | "increments" => Kind::Integer,
            "seconds" => Kind::Number,
            _ => Kind::Text,
        };
        column(name, kind)
    };
    let keys = study.keys().iter().zip(study.numeric());
    let wanted = study.wanted().iter().zip(numeric);
    COLUMNS_BEFORE
        .into_iter()
        .map(fixed)
        .chain(keys.map(|(key, is_number)| column(key, number(is_number))))
        .chain(COLUMNS_AFTER.into_iter().map(fixed))
        .chain(wanted.map(|(one, is_number)| column(&one.name, number(*is_number))))
        .chain(
            study
                .derived()
                .iter()
                .map(|one| column(&one.name, Kind::Number)),
        )
        .collect()
}

fn cells(study: &Study, columns: &[Column], case: &Case, row: &Row) -> Vec<Cell> {
    let text = |text: &Option<String>| text.clone().map_or(Cell::Empty, Cell::Text);
    let mut cells = vec![
        Cell::Integer(row.case.cast_signed()),
        Cell::Text(row.id.clone()),
    ];
    cells.extend(
        case.values
            .iter()
            .zip(study.numeric())
            .map(|(value, is_number)| match value {
                None => Cell::Empty,
                Some(value) if is_number => {
                    let number = value
                        .as_float()
                        .or(value.as_integer().map(|whole| whole as f64));
                    number.map_or(Cell::Empty, Cell::Number)
                }
                Some(value) => Cell::Text(cell(value)),
            }),
    );
    cells.extend([
        Cell::Text(row.termination.clone()),
        text(&row.cause),
        text(&row.message),
        Cell::Integer(row.attempts.into()),
        Cell::Integer(row.increments.into()),
        Cell::Number(row.seconds),
    ]);
    let kinds = columns.iter().skip(cells.len()).map(|column| column.kind);
    let kinds = kinds.take(study.wanted().len());
    let results = row.results.iter().chain(std::iter::repeat(&Value::Null));
    cells.extend(kinds.zip(results).map(|(kind, value)| result(kind, value)));
    let derived = if row.is_converged() {
        study.derive(case, &row.results)
    } else {
        vec![None; study.derived().len()]
    };
    cells.extend(
        derived
            .into_iter()
            .map(|value| value.map_or(Cell::Empty, Cell::Number)),
    );
    cells
}

fn result(kind: Kind, value: &Value) -> Cell {
    match (kind, value) {
        (_, Value::Null) => Cell::Empty,
        (Kind::Number | Kind::Integer, value) => value.as_f64().map_or(Cell::Empty, Cell::Number),
        (Kind::Text, Value::String(text)) => Cell::Text(text.clone()),
        (Kind::Text, other) => Cell::Text(other.to_string()),
    }
}
