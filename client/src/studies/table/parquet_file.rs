//! A table as Apache Parquet: 64-bit integers, doubles and UTF-8 texts, each of which may lack.

use std::fs::File;
use std::io;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;

use super::{Cell, Column, Kind, Sink};
use crate::terminal::whole_file::Unfinished;

/// Rows that are held until they are written together.
const GROUP: usize = 16 * 1024;

pub(super) struct ParquetFile {
    writer: SerializedFileWriter<File>,
    columns: Vec<Held>,
    rows: usize,
    file: Unfinished,
}

/// Cells of a column that are not written yet; a level of 1 for each that is there.
struct Held {
    levels: Vec<i16>,
    values: Values,
}

enum Values {
    Integers(Vec<i64>),
    Numbers(Vec<f64>),
    Texts(Vec<ByteArray>),
}

impl ParquetFile {
    pub(super) fn new(file: Unfinished, columns: &[Column]) -> io::Result<Self> {
        let fields = columns.iter().map(field);
        let fields = fields.collect::<Result<Vec<_>, _>>().map_err(told)?;
        let schema = Type::group_type_builder("study")
            .with_fields(fields)
            .build();
        let properties = Arc::new(WriterProperties::builder().build());
        let schema = Arc::new(schema.map_err(told)?);
        let writer = SerializedFileWriter::new(file.file.try_clone()?, schema, properties);
        Ok(Self {
            writer: writer.map_err(told)?,
            columns: columns
                .iter()
                .map(|column| Held::new(column.kind))
                .collect(),
            rows: 0,
            file,
        })
    }

    fn flush(&mut self) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        for held in &mut self.columns {
            if let Some(column) = group.next_column()? {
                held.write(column)?;
            }
        }
        self.rows = 0;
        group.close().map(|_| ())
    }
}

impl Sink for ParquetFile {
    fn row(&mut self, cells: Vec<Cell>) -> io::Result<()> {
        for (held, cell) in self.columns.iter_mut().zip(cells) {
            held.push(cell);
        }
        self.rows += 1;
        match self.rows {
            GROUP => self.flush().map_err(told),
            _ => Ok(()),
        }
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        if self.rows > 0 {
            self.flush().map_err(told)?;
        }
        self.writer.close().map_err(told)?;
        self.file.finish()
    }
}

fn field(column: &Column) -> Result<Arc<Type>, ParquetError> {
    let (physical, logical) = match column.kind {
        Kind::Integer => (Physical::INT64, None),
        Kind::Number => (Physical::DOUBLE, None),
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    let builder = Type::primitive_type_builder(&column.name, physical);
    let builder = builder.with_repetition(Repetition::OPTIONAL);
    builder.with_logical_type(logical).build().map(Arc::new)
}

impl Held {
    fn new(kind: Kind) -> Self {
        let values = match kind {
            Kind::Integer => Values::Integers(Vec::new()),
            Kind::Number => Values::Numbers(Vec::new()),
            Kind::Text => Values::Texts(Vec::new()),
        };
        let levels = Vec::new();
        Self { levels, values }
    }

    fn push(&mut self, cell: Cell) {
        let is_there = match (&mut self.values, cell) {
            (Values::Integers(all), Cell::Integer(value)) => push(all, value),
            (Values::Numbers(all), Cell::Number(value)) => push(all, value),
            (Values::Texts(all), Cell::Text(text)) => push(all, text.into_bytes().into()),
            (Values::Integers(_) | Values::Numbers(_) | Values::Texts(_), _) => false,
        };
        self.levels.push(is_there.into());
    }

    fn write(&mut self, column: SerializedColumnWriter<'_>) -> Result<(), ParquetError> {
        let levels = std::mem::take(&mut self.levels);
        match &mut self.values {
            Values::Integers(all) => write::<Int64Type>(column, all, &levels),
            Values::Numbers(all) => write::<DoubleType>(column, all, &levels),
            Values::Texts(all) => write::<ByteArrayType>(column, all, &levels),
        }
    }
}

fn push<T>(all: &mut Vec<T>, value: T) -> bool {
    all.push(value);
    true
}

fn write<T: DataType>(
    mut column: SerializedColumnWriter<'_>,
    values: &mut Vec<T::T>,
    levels: &[i16],
) -> Result<(), ParquetError> {
    column
        .typed::<T>()
        .write_batch(values, Some(levels), None)?;
    values.clear();
    column.close()
}

fn told(error: ParquetError) -> io::Error {
    let ParquetError::External(inner) = error else {
        return io::Error::other(error);
    };
    match inner.downcast::<io::Error>() {
        Ok(inner) => *inner,
        Err(other) => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use parquet::file::reader::{FileReader as _, SerializedFileReader};

    use super::*;
    use crate::terminal::whole_file;

    #[test]
    fn what_is_written_is_read_with_its_types_and_gaps_over_several_groups() {
        let path = std::env::temp_dir().join(format!("signorini-{}.parquet", std::process::id()));
        let kinds = [Kind::Integer, Kind::Number, Kind::Text];
        let columns = kinds.map(|kind| Column {
            name: format!("{kind:?}"),
            kind,
        });
        let file = whole_file::begin(&path).unwrap();
        let mut sink = Box::new(ParquetFile::new(file, &columns).unwrap());
        let rows = GROUP as i64 + 5;
        for row in 0..rows {
            let number = if row % 2 == 0 {
                Cell::Number(0.1)
            } else {
                Cell::Empty
            };
            let text = Cell::Text(format!("row {row}"));
            sink.row(vec![Cell::Integer(row), number, text]).unwrap();
        }
        sink.finish().unwrap();
        let reader = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
        assert_eq!(reader.metadata().num_row_groups(), 2);
        let read: Vec<String> = reader
            .into_iter()
            .map(|row| row.unwrap().to_string())
            .collect();
        assert_eq!(read.len() as i64, rows);
        assert_eq!(read[0], "{Integer: 0, Number: 0.1, Text: \"row 0\"}");
        let last = format!("{{Integer: {}, Number: 0.1, Text: \"row {0}\"}}", rows - 1);
        assert_eq!(read[read.len() - 1], last);
        assert_eq!(read[1], "{Integer: 1, Number: null, Text: \"row 1\"}");
        std::fs::remove_file(&path).unwrap();
    }
}
