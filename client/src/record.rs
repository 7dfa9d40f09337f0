//! What a command makes of results: lines, files, a progress bar and a table.

use std::time::{Duration, Instant};

use signorini_client::result_line::{self, Totals};
use signorini_client::solve::{Event, Increment};
use signorini_proto::v1;

use crate::exit::{Exit, Failure};
use crate::output::LineSink;
use crate::progress::{Progress, Visibility};
use crate::results::ResultFolder;
use crate::table;
use crate::text::{note, print};

/// Between two updates of a progress bar.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(50);

/// Everything that a command writes to and has gathered.
pub(crate) struct Record {
    pub(crate) progress: Progress,
    lines: LineSink,
    folder: Option<ResultFolder>,
    plan: v1::Plan,
    reports: Vec<v1::StepReport>,
    totals: Totals,
    visibility: Visibility,
    /// What the reader doubts in scene and mesh, until the plan comes.
    of_input: Vec<String>,
}

impl Record {
    /// For a run of these steps.
    pub(crate) fn new(lines: LineSink, steps: &[v1::LoadStep], visibility: Visibility) -> Self {
        let increments = steps.iter().map(|step| step.increments.unwrap_or(1).max(1));
        let increments = increments.map(i64::from).sum::<i64>().unsigned_abs();
        Self {
            progress: Progress::new(increments, visibility),
            lines,
            folder: None,
            plan: v1::Plan::default(),
            reports: Vec::new(),
            totals: Totals::default(),
            visibility,
            of_input: Vec::new(),
        }
    }

    /// Makes the folder for the results and starts its result lines anew.
    pub(crate) fn open(&mut self, folder: ResultFolder) -> Result<(), Failure> {
        self.lines.open_file(&folder.lines())?;
        self.folder = Some(folder);
        Ok(())
    }

    /// Tells people what the reader doubts in scene and mesh, and keeps it for the plan.
    pub(crate) fn input(&mut self, warnings: &[String]) {
        self.warn(warnings);
        self.of_input = warnings.to_vec();
    }

    /// Writes the plan, which comes first, with what the reader doubts.
    pub(crate) fn plan(&mut self, mut plan: v1::Plan) -> Result<(), Failure> {
        self.warn(&plan.warnings);
        plan.warnings.splice(..0, self.of_input.drain(..));
        self.lines.write(&result_line::plan(&plan))?;
        self.plan = plan;
        Ok(())
    }

    /// Tells people about warnings.
    fn warn(&self, warnings: &[String]) {
        if self.visibility == Visibility::Shown {
            for warning in warnings {
                self.progress.note(&format!("warning: {warning}"));
            }
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
        if self.visibility == Visibility::Shown {
            self.progress.note(line);
        }
    }

    /// Takes a result; how its step ended, when it ends one.
    pub(crate) fn add(&mut self, increment: Increment) -> Result<Option<v1::Termination>, Failure> {
        self.lines.write(&result_line::step(&increment.report))?;
        if let Some(folder) = &mut self.folder {
            folder.add(&increment)?;
            if increment.fields_dropped {
                self.warn(&["the fields of a result are no longer kept by the server".to_owned()]);
            }
        }
        let termination = increment.report.termination();
        self.totals.add(&increment.report);
        self.reports.push(increment.report);
        self.progress.finished();
        Ok(increment.last.then_some(termination))
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

    /// Summary and table, also of a run that failed half-way.
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
        let summary = self.totals.summary(wall_seconds, peak_memory());
        self.lines.write(&summary)?;
        if self.visibility == Visibility::Shown {
            self.show_table()?;
        }
        outcome
    }

    fn show_table(&self) -> Result<(), Failure> {
        let mut text = table::results(&self.plan, &self.reports);
        if let Some(folder) = &self.folder {
            let series = folder.series();
            text.push_str(&format!("{:<18} {}\n", "written", series.display()));
        }
        if self.lines.has_stdout() {
            note(&text);
            return Ok(());
        }
        print(&text)
    }
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
