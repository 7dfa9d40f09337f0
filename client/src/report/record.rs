//! What a command makes of results: lines, files, a progress line and a table.

use std::time::{Duration, Instant};

use signorini_client::result_line::{self, Totals};
use signorini_client::solve::{Event, Increment};
use signorini_proto::v1;

use crate::report::page;
use crate::report::path_csv::PathCsv;
use crate::report::results::ResultFolder;
use crate::report::results_csv::ResultsCsv;
use crate::report::rounds;
use crate::report::table::{self, Detail, Rows};
use crate::report::travel::Travels;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::output::LineSink;
use crate::terminal::progress::{Progress, Verbosity};
use crate::terminal::stdout::print;
use crate::terminal::text::note;

/// Between two updates of a progress line.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(50);

/// Everything that a command writes to and has gathered.
pub(crate) struct Record {
    pub(crate) progress: Progress,
    lines: LineSink,
    folder: Option<Folder>,
    plan: v1::Plan,
    reports: Vec<v1::StepReport>,
    totals: Totals,
    travels: Travels,
    rows: Option<Rows>,
    verbosity: Verbosity,
    /// What the reader doubts in scene and mesh, until the plan comes.
    of_input: Vec<String>,
    /// Meshes on the way to the one that is solved, until the plan comes.
    rounds: Vec<result_line::Round>,
}

/// The folder of `--out`.
struct Folder {
    results: ResultFolder,
    csv: ResultsCsv,
    path: PathCsv,
}

impl Record {
    /// For a run of all steps of a scene.
    pub(crate) fn new(lines: LineSink, scene: &v1::Scene, verbosity: Verbosity) -> Self {
        let steps = &scene.steps;
        let increments = steps.iter().map(|step| step.increments.unwrap_or(1).max(1));
        let increments = increments.map(i64::from).sum::<i64>().unsigned_abs();
        Self {
            progress: Progress::new(increments, verbosity),
            lines,
            folder: None,
            plan: v1::Plan::default(),
            reports: Vec::new(),
            totals: Totals::default(),
            travels: Travels::of(steps),
            // The result of the only increment is told in full anyway.
            rows: (increments != 1 && verbosity != Verbosity::Quiet).then(|| Rows::of(scene)),
            verbosity,
            of_input: Vec::new(),
            rounds: Vec::new(),
        }
    }

    /// Makes the folder for the results of `scene` and starts its files anew.
    pub(crate) fn open(&mut self, results: ResultFolder, scene: &v1::Scene) -> Result<(), Failure> {
        self.lines.open_file(&results.lines())?;
        let csv = ResultsCsv::create(results.path(), scene)?;
        let path = PathCsv::new(results.path(), scene)?;
        self.folder = Some(Folder { results, csv, path });
        Ok(())
    }

    /// Tells people what the reader doubts in scene and mesh, and keeps it for the plan.
    pub(crate) fn input(&mut self, warnings: &[String]) {
        self.warn(warnings);
        self.of_input = warnings.to_vec();
    }

    /// Writes the plan, which comes first, with what the reader doubts and what the scene
    /// calls its units.
    pub(crate) fn plan(
        &mut self,
        mut plan: v1::Plan,
        units: Option<&v1::UnitNames>,
    ) -> Result<(), Failure> {
        self.warn(&plan.warnings);
        plan.warnings.splice(..0, self.of_input.drain(..));
        self.lines.write(&result_line::plan(&plan, units))?;
        for round in self.rounds.drain(..) {
            self.lines.write(&result_line::round(&round))?;
        }
        self.plan = plan;
        Ok(())
    }

    /// Takes what a mesh gave on the way to the one that is solved.
    pub(crate) fn round(&mut self, round: result_line::Round) {
        self.remark(&rounds::told(&round));
        self.rounds.push(round);
    }

    /// Takes why the last mesh is that: a warning where goals are not known as well as was asked.
    pub(crate) fn refined(&mut self, end: &str, why: &str) {
        let mut is_reached = false;
        if let Some(last) = self.rounds.last_mut() {
            last.end = Some(end.to_owned());
            last.why = Some(why.to_owned());
            is_reached = last.is_reached();
        }
        if !is_reached {
            self.warn(&[format!("accuracy: not reached: {why}")]);
        }
    }

    /// Tells people about warnings.
    fn warn(&self, warnings: &[String]) {
        for warning in warnings {
            self.remark(&format!("warning: {warning}"));
        }
    }

    /// Every iteration for result lines, some of them for people.
    pub(crate) fn iteration_interval(&self) -> Option<Duration> {
        (!self.lines.is_open()).then_some(PROGRESS_INTERVAL)
    }

    /// Takes an event; how its step ended, when it ends one.
    pub(crate) fn take(&mut self, event: Event) -> Result<Option<v1::Termination>, Failure> {
        match event {
            Event::Iteration(statistics) => {
                self.lines.write(&result_line::iteration(&statistics))?;
                self.progress
                    .iteration(&statistics.report.unwrap_or_default());
            }
            Event::Increment(increment) => return self.add(*increment),
            Event::Rejected { refusal, .. } => return Err(Failure::from(&*refusal)),
            Event::ConnectionLost { cause } => self.remark(&format!("{cause}; trying again")),
            Event::Reconnected { .. } => self.remark("connected again; nothing is lost"),
            Event::Heartbeat(_) => {}
        }
        Ok(None)
    }

    /// For people who watch the progress.
    fn remark(&self, line: &str) {
        if self.verbosity != Verbosity::Quiet {
            self.progress.note(line);
        }
    }

    /// Takes a result; how its step ended, when it ends one.
    pub(crate) fn add(&mut self, increment: Increment) -> Result<Option<v1::Termination>, Failure> {
        self.lines.write(&result_line::step(&increment.report))?;
        self.travels.see(&increment.report);
        if let Some(folder) = &mut self.folder {
            folder.csv.add(&increment.report, &self.travels)?;
            folder.path.add(&increment)?;
            folder.results.add(&increment)?;
            if increment.fields_dropped {
                self.warn(&["the fields of a result are no longer kept by the server".to_owned()]);
            }
        }
        self.show_row(&increment.report)?;
        let termination = increment.report.termination();
        self.totals.add(&increment.report);
        self.reports.push(increment.report);
        self.progress.finished();
        Ok(increment.last.then_some(termination))
    }

    /// A row at once, so that a log tells how far a run is.
    fn show_row(&mut self, report: &v1::StepReport) -> Result<(), Failure> {
        let Some(rows) = &mut self.rows else {
            return Ok(());
        };
        let row = rows.row(report, &self.travels);
        self.progress.above(|| tell(&self.lines, &row))
    }

    /// Whether no result has come.
    pub(crate) fn is_empty(&self) -> bool {
        self.reports.is_empty()
    }

    /// What the last result means; well without one.
    pub(crate) fn exit(&self) -> Exit {
        self.reports
            .last()
            .map_or(Exit::Ok, |last| Exit::from(last.termination()))
    }

    /// Summary, page and table, also of a run that failed half-way.
    pub(crate) fn finish(
        mut self,
        outcome: Result<Exit, Failure>,
        started: Instant,
    ) -> Result<Exit, Failure> {
        self.progress.clear();
        if self.is_empty() {
            return outcome;
        }
        let wall_seconds = started.elapsed().as_secs_f64();
        let summary = self.totals.summary(
            wall_seconds,
            peak_memory(),
            &table::never_touched(&self.reports),
        );
        self.lines.write(&summary)?;
        let written = self.write_page();
        if self.verbosity != Verbosity::Quiet {
            self.show_table()?;
        }
        // What went wrong before says more than a page that is missing.
        outcome.and_then(|exit| written.map(|()| exit))
    }

    fn write_page(&self) -> Result<(), Failure> {
        let folder = self.folder.as_ref();
        folder.map_or(Ok(()), |folder| {
            page::write(folder.results.path()).map(|_| ())
        })
    }

    fn show_table(&self) -> Result<(), Failure> {
        let detail = match self.verbosity {
            Verbosity::Verbose => Detail::Full,
            Verbosity::Normal | Verbosity::Quiet => Detail::Short,
        };
        let mut text = table::results(&self.plan, &self.reports, &self.travels, detail);
        if self.rows.is_some() {
            text.insert(0, '\n');
        }
        if let Some(folder) = &self.folder {
            let series = folder.results.series();
            text.push_str(&format!("{:<18} {}\n", "written", series.display()));
            let page = page::path(folder.results.path());
            text.push_str(&format!("{:<18} {}\n", "", page.display()));
        }
        tell(&self.lines, &text)
    }
}

/// To stdout, unless result lines go there.
fn tell(lines: &LineSink, text: &str) -> Result<(), Failure> {
    if lines.has_stdout() {
        note(text);
        return Ok(());
    }
    print(text)
}

/// Peak resident memory of this process in bytes, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}
