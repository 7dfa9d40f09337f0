//! Where result lines go: stdout, a file, both or nowhere.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::terminal::exit::Failure;
use crate::terminal::stdout::print;
use crate::terminal::whole_file;

/// Receives result lines.
pub(crate) struct LineSink {
    stdout: Option<()>,
    file: Option<(PathBuf, BufWriter<File>)>,
}

impl LineSink {
    /// Prints each line if `json` is asked for.
    pub(crate) fn for_json(json: bool) -> Self {
        Self {
            stdout: json.then_some(()),
            file: None,
        }
    }

    /// Whether lines are printed.
    pub(crate) fn has_stdout(&self) -> bool {
        self.stdout.is_some()
    }

    /// From now on also writes each line to a new file.
    pub(crate) fn open_file(&mut self, path: &Path) -> Result<(), Failure> {
        let file = whole_file::create(path).map_err(|error| Failure::unwritable(path, &error))?;
        self.file = Some((path.to_owned(), BufWriter::new(file)));
        Ok(())
    }

    /// Whether anybody reads the lines.
    pub(crate) fn is_open(&self) -> bool {
        self.stdout.is_some() || self.file.is_some()
    }

    /// Writes one object as one line.
    pub(crate) fn write(&mut self, line: &Value) -> Result<(), Failure> {
        let text = format!("{line}\n");
        if let Some((path, file)) = &mut self.file {
            let written = file.write_all(text.as_bytes()).and_then(|()| file.flush());
            written.map_err(|error| Failure::unwritable(path, &error))?;
        }
        self.stdout.map_or(Ok(()), |()| print(&text))
    }
}
