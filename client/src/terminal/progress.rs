//! A progress line, on terminals only.
//!
//! It is put together of whole parts, the most wanted first, as many as the terminal
//! has columns for: no number is cut.

use console::Term;
use indicatif::{ProgressBar, ProgressStyle};
use signorini_proto::v1;

/// Without colours, so that `NO_COLOR` holds by itself.
const NARROW: &str = "{msg}  {pos}/{len}  {elapsed}";
const WIDE: &str = "{msg}  [{bar:20}] {pos}/{len}  {elapsed}";
const CASES: &str = "{pos}/{len} cases  [{bar:20}] {per_sec}  {elapsed} + {eta}  {msg}";
/// Columns from which there is room for the bar.
const WITH_BAR: usize = 100;
/// Of a terminal that does not tell.
const USUAL_COLUMNS: usize = 80;

/// How much is told beside the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verbosity {
    /// Nothing but errors.
    Quiet,
    /// Progress, warnings, a table.
    Normal,
    /// And what the solver did.
    Verbose,
}

impl Verbosity {
    /// As `--verbose` asks for.
    pub(crate) fn of(verbose: bool) -> Self {
        if verbose { Self::Verbose } else { Self::Normal }
    }
}

/// Shows the newest iteration and the finished increments.
pub(crate) struct Progress {
    bar: ProgressBar,
    increments: u64,
}

impl Progress {
    /// A line over all increments of a run; hidden where stderr is no terminal.
    pub(crate) fn new(increments: u64, verbosity: Verbosity) -> Self {
        let bar = match verbosity {
            Verbosity::Normal | Verbosity::Verbose => ProgressBar::new(increments),
            Verbosity::Quiet => ProgressBar::hidden(),
        };
        let template = if columns() < WITH_BAR { NARROW } else { WIDE };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("=> "));
        }
        Self { bar, increments }
    }

    /// What is being done.
    pub(crate) fn phase(&self, phase: &str) {
        self.bar.set_message(phase.to_owned());
        self.bar.tick();
    }

    /// Newest statistics.
    pub(crate) fn iteration(&self, report: &v1::IterationReport) {
        let line = line(report, columns(), self.increments);
        self.bar.set_message(line);
    }

    /// One increment is done.
    pub(crate) fn finished(&self) {
        self.bar.inc(1);
    }

    /// Prints a line above the progress.
    pub(crate) fn note(&self, line: &str) {
        self.above(|| crate::terminal::text::note(&format!("{line}\n")));
    }

    /// Lets something be written above the progress.
    pub(crate) fn above<T>(&self, write: impl FnOnce() -> T) -> T {
        self.bar.suspend(write)
    }

    /// Removes the line.
    pub(crate) fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

/// Shows how many cases of a study are done.
pub(crate) struct CaseProgress {
    bar: ProgressBar,
    verbosity: Verbosity,
}

impl CaseProgress {
    /// A line over all cases; hidden where stderr is no terminal.
    pub(crate) fn new(cases: u64, verbosity: Verbosity) -> Self {
        let bar = match verbosity {
            Verbosity::Normal | Verbosity::Verbose => ProgressBar::new(cases),
            Verbosity::Quiet => ProgressBar::hidden(),
        };
        if let Ok(style) = ProgressStyle::with_template(CASES) {
            bar.set_style(style.progress_chars("=> "));
        }
        Self { bar, verbosity }
    }

    /// So many cases are done, some of them without values.
    pub(crate) fn set(&self, done: u64, failures: u64) {
        self.bar.set_position(done);
        if failures > 0 {
            self.bar.set_message(format!("{failures} without values"));
        }
    }

    /// A line for logs, where no terminal shows the bar.
    pub(crate) fn log(&self) {
        if self.bar.is_hidden() && self.verbosity != Verbosity::Quiet {
            let (done, all) = (self.bar.position(), self.bar.length().unwrap_or_default());
            crate::terminal::text::note(&format!(
                "{done} of {all} cases  {}\n",
                self.bar.message()
            ));
        }
    }

    /// Prints a line above the progress.
    pub(crate) fn note(&self, line: &str) {
        let print = || crate::terminal::text::note(&format!("{line}\n"));
        self.bar.suspend(print);
    }

    /// Removes the line.
    pub(crate) fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

/// Columns of the terminal behind stderr.
fn columns() -> usize {
    let size = Term::stderr().size_checked();
    size.map_or(USUAL_COLUMNS, |(_, columns)| columns.into())
}

/// The parts of a line that fit beside the count of increments and the time.
fn line(report: &v1::IterationReport, columns: usize, increments: u64) -> String {
    let digits = increments.max(1).ilog10() as usize + 1;
    let bar = if columns < WITH_BAR { 0 } else { 23 };
    // Two gaps, the count, an hour and its colons, and the column that terminals wrap at.
    let taken = 4 + 2 * digits + 1 + 8 + bar + 1;
    let room = columns.saturating_sub(taken);
    let parts = [
        residual(largest(report)),
        format!("in contact {}", report.active_vertices),
        format!("iterations {}", report.krylov_iterations),
        format!("SQP {}", report.sqp_iteration),
    ];
    let mut line = format!("step {}.{}", report.step, report.increment);
    for part in parts {
        if line.len() + 2 + part.len() > room {
            break;
        }
        line.push_str("  ");
        line.push_str(&part);
    }
    line
}

/// The residual in words. It is relative: above one it says only that the search for the
/// equilibrium is far from it, however large it is.
fn residual(value: f64) -> String {
    if value > 1.0 {
        "residual > 1".to_owned()
    } else {
        format!("residual {value:.1e}")
    }
}

fn largest(report: &v1::IterationReport) -> f64 {
    let residuals = report.residuals.unwrap_or_default();
    residuals
        .equilibrium
        .max(residuals.incompressibility)
        .max(residuals.complementarity)
        .max(residuals.gap)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report() -> v1::IterationReport {
        v1::IterationReport {
            step: 12,
            increment: 34,
            sqp_iteration: 15,
            krylov_iterations: 14_070,
            active_vertices: 1180,
            residuals: Some(v1::Residuals {
                gap: 1.24e-7,
                ..Default::default()
            }),
            ..Default::default()
        }
    }

    #[test]
    fn a_residual_above_one_is_no_number_to_read() {
        assert_eq!(residual(2.2e8), "residual > 1");
        assert_eq!(residual(1.0), "residual 1.0e0");
    }

    #[test]
    fn numbers_are_whole_at_every_width() {
        for (columns, expected) in [
            (
                120,
                "step 12.34  residual 1.2e-7  in contact 1180  iterations 14070",
            ),
            (80, "step 12.34  residual 1.2e-7  in contact 1180"),
            (60, "step 12.34  residual 1.2e-7"),
            (20, "step 12.34"),
        ] {
            let line = line(&report(), columns, 100);
            assert!(line.starts_with(expected), "{columns}: {line}");
            let fixed = if columns < WITH_BAR {
                "  100/100  00:00:00".len()
            } else {
                42
            };
            assert!(
                columns == 20 || line.len() + fixed < columns,
                "{columns}: {line}"
            );
        }
    }
}
