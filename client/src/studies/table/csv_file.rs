//! A table as CSV (RFC 4180); numbers have as many digits as the double has.

use std::fs::File;
use std::io::{self, BufWriter};

use super::{Cell, Column, Sink};
use crate::terminal::whole_file::Unfinished;

pub(super) struct CsvFile {
    writer: csv::Writer<BufWriter<File>>,
    file: Unfinished,
}

impl CsvFile {
    pub(super) fn new(file: Unfinished, columns: &[Column]) -> io::Result<Self> {
        let mut writer = csv::Writer::from_writer(BufWriter::new(file.file.try_clone()?));
        writer.write_record(columns.iter().map(|column| &column.name))?;
        Ok(Self { writer, file })
    }
}

impl Sink for CsvFile {
    fn row(&mut self, cells: Vec<Cell>) -> io::Result<()> {
        let texts = cells.into_iter().map(|cell| match cell {
            Cell::Integer(number) => number.to_string(),
            Cell::Number(number) => number.to_string(),
            Cell::Text(text) => text,
            Cell::Empty => String::new(),
        });
        Ok(self.writer.write_record(texts)?)
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.writer.flush()?;
        drop(self.writer);
        self.file.finish()
    }
}
