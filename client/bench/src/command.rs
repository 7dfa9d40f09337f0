//! The bench as a whole: measures what the arguments ask for and writes table,
//! figures and page.

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::arguments::Arguments;
use crate::error::BenchError;
use crate::extremes::{self, Finding, Trying, Verdict};
use crate::machine::Machine;
use crate::page::{self, LeftOut, Report};
use crate::peers;
use crate::picture::Figure;
use crate::plan::Plan;
use crate::recorded;
use crate::reference::References;
use crate::results::Results;
use crate::rounds::{Measured, Rounds};
use crate::row::{self, Row};
use crate::study_figures;
use crate::workshop::Workshop;

/// The program that a bench runs, and who watches it.
#[derive(Debug)]
pub struct Watched<I, N> {
    /// Path of the program, which understands `solve SCENE --json --quiet --set`.
    pub program: PathBuf,
    /// Ends when no more is to be measured; what was measured is written.
    pub interrupted: I,
    /// Told of each run, a line with its end.
    pub note: N,
}

/// How a bench ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The plan is done, or its time is over.
    Complete,
    /// As [`End::Complete`], but not one run met its tolerance.
    NothingConverged,
    /// Before the plan was done.
    Interrupted,
}

/// What a bench leaves behind.
#[derive(Clone, Debug)]
pub struct Finished {
    /// How it ended.
    pub end: End,
    /// The page that shows everything.
    pub page: PathBuf,
}

/// Runs the plan of `arguments` and writes `bench.csv`, the figures and `index.html`.
///
/// # Errors
/// [`BenchError`]; nothing is written then.
pub async fn run<I, N>(arguments: Arguments, watched: Watched<I, N>) -> Result<Finished, BenchError>
where
    I: Future<Output = ()>,
    N: Fn(&str),
{
    let plan = arguments.wishes().plan().map_err(BenchError::Arguments)?;
    if plan.is_empty() {
        let message = "--levels: no chosen scene has one of them";
        return Err(BenchError::Arguments(message.to_owned()));
    }
    let references = References::shipped().map_err(BenchError::Arguments)?;
    let peers = match &arguments.peers {
        Some(path) => peers::read(path).map_err(BenchError::Peers)?,
        None => peers::shipped().map_err(BenchError::Peers)?,
    };
    std::fs::create_dir_all(&arguments.out).map_err(BenchError::unwritable(&arguments.out))?;
    let started = Instant::now();
    let workshop = Workshop::open(arguments.meshes)?;
    let (end, measured, findings) = measure(&plan, &workshop, &arguments.out, watched).await?;
    let minutes = started.elapsed().as_secs_f64() / 60.0;
    let (left_out, rows) = divided(measured, &references);
    let results = Results {
        rows,
        recorded: recorded::rows().map_err(BenchError::Table)?,
        findings,
        peers,
        references,
        machine: Machine::here(),
    };
    let report = Report {
        chapters: results.chapters(),
        inquiries: study_figures::inquiries(&results, &plan.studies),
        left_out,
        minutes,
    };
    Ok(Finished {
        end: end_of(end, &results),
        page: write(&arguments.out, &results, &report)?,
    })
}

/// Until the plan is done or interrupted; what was measured is kept.
async fn measure<I, N>(
    plan: &Plan,
    workshop: &Workshop,
    out: &Path,
    watched: Watched<I, N>,
) -> Result<(End, Vec<Measured>, Vec<Finding>), BenchError>
where
    I: Future<Output = ()>,
    N: Fn(&str),
{
    let Watched {
        program,
        interrupted,
        note,
    } = watched;
    let mut rounds = Rounds::new(plan, workshop, program.clone());
    let times = (plan.trial_limit, Instant::now() + plan.budget);
    let mut trying = Trying::new((&plan.trials, &program), out, times);
    let everything = async {
        rounds.run(&note).await?;
        trying.run(&note).await
    };
    let end = tokio::select! {
        outcome = everything => outcome.map(|()| End::Complete)?,
        () = interrupted => End::Interrupted,
    };
    Ok((end, rounds.into_measured(), trying.into_findings()))
}

/// What did not run, and the rows of what did.
fn divided(measured: Vec<Measured>, references: &References) -> (Vec<LeftOut>, Vec<Row>) {
    let reason = |item: &Measured| Some((item.case.name(), item.left_out.clone()?));
    let left_out = measured.iter().filter_map(reason).collect();
    let rows = measured
        .into_iter()
        .filter_map(|item| Row::new(item, references));
    let mut rows: Vec<Row> = rows.collect();
    rows.sort_by_key(|row| row.case.family.name);
    (left_out, rows)
}

/// A bench in which nothing converged is no bench.
fn end_of(end: End, results: &Results) -> End {
    let is_right = |found: &Finding| found.verdict == Verdict::Right;
    let any = results.rows.iter().any(Row::converged) || results.findings.iter().any(is_right);
    if end == End::Complete && !any {
        return End::NothingConverged;
    }
    end
}

/// Writes all files and returns the path of the page.
fn write(out: &Path, results: &Results, report: &Report) -> Result<PathBuf, BenchError> {
    let file = |name: &str, content: &[u8]| {
        let path = out.join(name);
        std::fs::write(&path, content).map_err(BenchError::unwritable(&path))?;
        Ok(path)
    };
    let table = row::csv(&results.rows, &results.machine).map_err(BenchError::Table)?;
    file("bench.csv", &table)?;
    if !results.findings.is_empty() {
        let table = extremes::csv(&results.findings).map_err(BenchError::Table)?;
        file("extremes.csv", &table)?;
    }
    for Figure { name, svg } in report.figures() {
        file(&format!("{name}.svg"), svg.as_bytes())?;
    }
    file("index.html", page::html(results, report).as_bytes())
}
