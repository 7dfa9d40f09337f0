//! The study of stiff and extreme cases: scenes whose result is known without this
//! solver, each run once by a process of its own, with failures shown as such.
//!
//! `catalogue` lists the rows, `body` and `draft` make their meshes, `run` runs a row,
//! `verdict` compares it with what is known and `shown` makes table and figure. Scene
//! and mesh of every row stay in a folder beside the page, to be run again by hand.

mod body;
mod catalogue;
mod draft;
mod lines;
mod of_tests;
mod peer;
mod run;
mod shown;
mod verdict;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::error::BenchError;
use crate::extent::Extent;

pub(crate) use catalogue::Trial;
pub(crate) use run::Finding;
pub(crate) use shown::{csv, figure, peers_about, remark, table};
pub(crate) use verdict::Verdict;

/// The rows of an extent.
///
/// # Errors
/// What is wrong with the catalogue, which a test excludes.
pub(crate) fn trials(extent: Extent) -> Result<Vec<Trial>, String> {
    let mut trials = catalogue::trials()?;
    trials.retain(|trial| extent == Extent::Full || trial.quick);
    Ok(trials)
}

/// Runs rows one after the other.
#[derive(Debug)]
pub(crate) struct Trying<'a> {
    trials: &'a [Trial],
    program: &'a Path,
    folder: PathBuf,
    limit: Duration,
    ends: Instant,
    findings: Vec<Finding>,
}

impl<'a> Trying<'a> {
    /// With files in a folder below `out`; each row is stopped at `limit`, all at `ends`.
    pub(crate) fn new(
        (trials, program): (&'a [Trial], &'a Path),
        out: &Path,
        (limit, ends): (Duration, Instant),
    ) -> Self {
        Self {
            trials,
            program,
            folder: out.join("extremes"),
            limit,
            ends,
            findings: Vec::new(),
        }
    }

    /// All rows, or those before the time is over; `note` is told of each. What was found
    /// stays when the future is dropped.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) async fn run(&mut self, note: impl Fn(&str)) -> Result<(), BenchError> {
        if self.trials.is_empty() {
            return Ok(());
        }
        let folder = &self.folder;
        std::fs::create_dir_all(folder).map_err(BenchError::unwritable(folder))?;
        let peers = peer::peers().map_err(BenchError::Peers)?;
        for trial in self.trials {
            let left = self.ends.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(());
            }
            let files = (self.program, self.folder.as_path());
            let before = (self.findings.as_slice(), peers.as_slice());
            let found = run::run(trial, files, before, self.limit.min(left)).await?;
            note(&format!(
                "{}, {}: {}, {:.3} s\n",
                trial.family,
                trial.case,
                found.verdict.word(),
                found.seconds
            ));
            self.findings.push(found);
        }
        Ok(())
    }

    /// What was found so far.
    pub(crate) fn into_findings(self) -> Vec<Finding> {
        self.findings
    }
}
