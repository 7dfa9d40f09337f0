//! The log of a run: a line for the study, one for each begin of a case, one for its row.
//!
//! A line is written at once, so a process that is killed loses none that was finished; every
//! second they are brought to the disk, so a machine that stops loses one second of cases,
//! which are solved again. A last line without its end is cut off. Only one process has a log
//! at one time.

use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{BufRead as _, BufReader, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use signorini_client::study::MOST_CASES;

use super::bits::Bits;
use super::row::Row;
use crate::terminal::exit::{Exit, Failure};

/// Bytes of a line at most.
const LONGEST_LINE: u64 = 64 << 20;
/// Between two times that lines are brought to the disk.
const SYNC_INTERVAL: Duration = Duration::from_secs(1);

/// Of which study a log is.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Header {
    /// Digest of the study.
    pub(crate) study: String,
    /// Number of cases.
    pub(crate) cases: u64,
    /// Name of the mesh of its first case.
    pub(crate) mesh: String,
}

/// What a log that is there means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Start {
    /// Cases are solved anew; a log of an interrupted run is not thrown away, though.
    Anew,
    /// What it has is not solved again.
    Resume,
}

/// One line.
#[derive(Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
enum Line {
    Study(Header),
    Begin(u64),
    Row(Row),
}

/// An open log.
#[derive(Debug)]
pub(crate) struct RowLog {
    path: PathBuf,
    file: File,
    done: Bits,
    /// Times that cases were begun which are not done.
    begun: HashMap<u64, u32>,
    unsynced_since: Option<Instant>,
}

impl RowLog {
    /// Opens the log of a study; `see` gets the rows that it has.
    pub(crate) fn open(
        path: &Path,
        header: &Header,
        start: Start,
        see: impl FnMut(&Row),
    ) -> Result<Self, Failure> {
        let mut log = Self::lock(path, header.cases)?;
        match log.read(header, see)? {
            None => log.begin_anew(header)?,
            Some(found) if start == Start::Resume => log.take_up(&found, header)?,
            Some(found) if log.done() >= found.cases => log.begin_anew(header)?,
            Some(found) => return Err(log.interrupted(&found)),
        }
        Ok(log)
    }

    fn lock(path: &Path, cases: u64) -> Result<Self, Failure> {
        let mut options = OpenOptions::new();
        let file = options.read(true).append(true).create(true).open(path);
        let file = file.map_err(|error| Failure::unwritable(path, &error))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let message = format!("{}: another process runs this study", path.display());
                return Err(Failure::new(Exit::Refused, message));
            }
            Err(TryLockError::Error(error)) => return Err(Failure::unwritable(path, &error)),
        }
        Ok(Self {
            path: path.to_owned(),
            file,
            done: Bits::new(cases),
            begun: HashMap::new(),
            unsynced_since: None,
        })
    }

    /// The header that is there; cuts off a line without an end.
    fn read(
        &mut self,
        header: &Header,
        mut see: impl FnMut(&Row),
    ) -> Result<Option<Header>, Failure> {
        let (mut found, mut whole, mut number) = (None, 0, 0_u64);
        let mut reader = BufReader::new(self.file.try_clone().map_err(|e| self.fault(&e))?);
        reader.rewind().map_err(|error| self.fault(&error))?;
        let mut text = Vec::new();
        loop {
            text.clear();
            let read = (&mut reader)
                .take(LONGEST_LINE)
                .read_until(b'\n', &mut text);
            let read = read.map_err(|error| self.fault(&error))?;
            if text.last() != Some(&b'\n') {
                break;
            }
            number += 1;
            let line = serde_json::from_slice(&text);
            let line = line.map_err(|error| self.damaged(number, &error.to_string()))?;
            match (line, &found) {
                (Line::Study(study), None) if study.cases <= MOST_CASES => {
                    self.done = Bits::new(study.cases);
                    found = Some(study);
                }
                (Line::Study(_), _) => return Err(self.damaged(number, "a study out of place")),
                (_, None) => return Err(self.damaged(number, "the study is missing")),
                (Line::Begin(case), _) if !self.is_done(case) => {
                    *self.begun.entry(case).or_default() += 1;
                }
                (Line::Begin(_), _) => {}
                (Line::Row(row), Some(study)) => {
                    if self.note(row.case) && study == header {
                        see(&row);
                    }
                }
            }
            whole += read as u64;
        }
        self.cut(whole)?;
        Ok(found)
    }

    fn cut(&self, bytes: u64) -> Result<(), Failure> {
        let cut = self.file.set_len(bytes);
        cut.map_err(|error| Failure::unwritable(&self.path, &error))
    }

    fn begin_anew(&mut self, header: &Header) -> Result<(), Failure> {
        self.cut(0)?;
        self.done = Bits::new(header.cases);
        self.begun.clear();
        self.write(&Line::Study(header.clone()))
    }

    /// Goes on with what it has.
    fn take_up(&self, found: &Header, header: &Header) -> Result<(), Failure> {
        if found == header {
            return Ok(());
        }
        let what = if found.mesh == header.mesh {
            "study or scene"
        } else {
            "mesh"
        };
        let message = format!(
            "{}: is of another {what}: it was changed; remove the log to solve all cases anew",
            self.path.display()
        );
        Err(Failure::new(Exit::Invalid, message))
    }

    fn interrupted(&self, found: &Header) -> Failure {
        let message = format!(
            "{}: is of a study that was interrupted, of {} cases; --resume goes on with it, and \
             all cases are solved anew when the file is removed",
            self.path.display(),
            found.cases
        );
        Failure::new(Exit::Usage, message)
    }

    fn fault(&self, error: &std::io::Error) -> Failure {
        Failure::unreadable(&self.path, error)
    }

    fn damaged(&self, line: u64, why: &str) -> Failure {
        let message = format!("{}: line {line}: {why}", self.path.display());
        Failure::new(Exit::Invalid, message)
    }

    fn note(&mut self, case: u64) -> bool {
        self.begun.remove(&case);
        self.done.insert(case)
    }

    /// Where it lies.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether a case has its row.
    pub(crate) fn is_done(&self, case: u64) -> bool {
        self.done.has(case)
    }

    /// How many cases have rows.
    pub(crate) fn done(&self) -> u64 {
        self.done.count()
    }

    /// Times that a case was begun without a row to show for it.
    pub(crate) fn begun(&self, case: u64) -> u32 {
        self.begun.get(&case).copied().unwrap_or_default()
    }

    /// Notes that a case is about to be solved.
    pub(crate) fn begin(&mut self, case: u64) -> Result<(), Failure> {
        *self.begun.entry(case).or_default() += 1;
        self.write(&Line::Begin(case))
    }

    /// Keeps a row; whether the case had none.
    pub(crate) fn add(&mut self, row: &Row) -> Result<bool, Failure> {
        if !self.note(row.case) {
            return Ok(false);
        }
        self.write(&Line::Row(row.clone()))?;
        let since = *self.unsynced_since.get_or_insert_with(Instant::now);
        if since.elapsed() >= SYNC_INTERVAL {
            self.sync()?;
        }
        Ok(true)
    }

    /// Brings the lines to the disk.
    pub(crate) fn sync(&mut self) -> Result<(), Failure> {
        self.unsynced_since = None;
        let synced = self.file.sync_data();
        synced.map_err(|error| Failure::unwritable(&self.path, &error))
    }

    fn write(&mut self, line: &Line) -> Result<(), Failure> {
        let text = serde_json::to_string(line);
        let text = text.map_err(|error| Failure::new(Exit::Server, error.to_string()))?;
        let written = self.file.write_all(format!("{text}\n").as_bytes());
        written.map_err(|error| Failure::unwritable(&self.path, &error))
    }
}

/// The row that a line has, if it has one.
pub(crate) fn row_of(line: &[u8]) -> Option<Row> {
    match serde_json::from_slice(line).ok()? {
        Line::Row(row) => Some(row),
        Line::Study(_) | Line::Begin(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(study: &str) -> Header {
        Header {
            study: study.to_owned(),
            cases: 3,
            mesh: "meshes/1".to_owned(),
        }
    }

    fn row(case: u64) -> Row {
        Row::without(case, &format!("{case}-id"), "converged")
    }

    struct Place(PathBuf);

    impl Drop for Place {
        fn drop(&mut self) {
            // A file that stays is no fault of what is tested.
            let _left = std::fs::remove_file(&self.0);
        }
    }

    impl Place {
        fn new(test: &str) -> Self {
            let name = format!("signorini-log-{test}-{}", std::process::id());
            Self(std::env::temp_dir().join(name))
        }

        fn open(&self, study: &str, start: Start) -> Result<(RowLog, Vec<u64>), Failure> {
            let mut seen = Vec::new();
            let log = RowLog::open(&self.0, &header(study), start, |row| seen.push(row.case))?;
            Ok((log, seen))
        }

        fn add(&self, text: &str) {
            let mut file = OpenOptions::new().append(true).open(&self.0).unwrap();
            file.write_all(text.as_bytes()).unwrap();
        }
    }

    #[test]
    fn what_is_there_is_taken_up_but_for_a_line_without_its_end() {
        let place = Place::new("taken");
        let (mut log, _) = place.open("a", Start::Anew).unwrap();
        log.begin(1).unwrap();
        assert!(log.add(&row(1)).unwrap() && !log.add(&row(1)).unwrap());
        log.begin(2).unwrap();
        assert!(
            place
                .open("a", Start::Resume)
                .unwrap_err()
                .text()
                .contains("another process")
        );
        drop(log);
        place.add("{\"row\":{\"case\":0");
        let (mut log, seen) = place.open("a", Start::Resume).unwrap();
        assert_eq!(
            (seen, log.done(), log.begun(1), log.begun(2)),
            (vec![1], 1, 0, 1)
        );
        log.add(&row(0)).unwrap();
        drop(log);
        assert_eq!(place.open("a", Start::Resume).unwrap().1, [1, 0]);
    }

    #[test]
    fn only_a_whole_study_is_written_over_and_only_the_same_is_taken_up() {
        let place = Place::new("whole");
        let (mut log, _) = place.open("a", Start::Anew).unwrap();
        log.add(&row(0)).unwrap();
        drop(log);
        assert!(
            place
                .open("a", Start::Anew)
                .unwrap_err()
                .text()
                .contains("interrupted")
        );
        assert!(
            place
                .open("b", Start::Resume)
                .unwrap_err()
                .text()
                .contains("another study")
        );
        let (mut log, _) = place.open("a", Start::Resume).unwrap();
        log.add(&row(1)).unwrap();
        log.add(&row(2)).unwrap();
        drop(log);
        assert_eq!(place.open("b", Start::Anew).unwrap().0.done(), 0);
    }

    #[test]
    fn damaged_logs_name_their_line() {
        let place = Place::new("damaged");
        drop(place.open("a", Start::Anew).unwrap());
        place.add("{\"begin\":0}\nnonsense\n");
        let told = place.open("a", Start::Resume).unwrap_err().text();
        assert!(told.contains("line 3"), "{told}");
        std::fs::write(&place.0, "{\"row\":{}}\n").unwrap();
        assert!(
            place
                .open("a", Start::Resume)
                .unwrap_err()
                .text()
                .contains("line 1")
        );
        let huge = "{\"study\":{\"study\":\"a\",\"cases\":18446744073709551615,\"mesh\":\"m\"}}\n";
        std::fs::write(&place.0, huge).unwrap();
        assert!(
            place
                .open("a", Start::Resume)
                .unwrap_err()
                .text()
                .contains("line 1")
        );
    }
}
