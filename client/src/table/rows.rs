//! One row an increment, written when it is done.

use signorini_proto::{v1, words};

use crate::text::{one_line, percent, with_error};
use crate::travel::Travels;

/// Obstacles that have a column: more would not fit on a line.
const MOST: usize = 4;
/// Characters of a force with its error.
const WIDTH: usize = 20;

/// The table under construction.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    /// Obstacles with a column, once the header is written.
    columns: Option<Vec<String>>,
}

impl Rows {
    /// The row of an increment, below the header when it is the first.
    pub(crate) fn row(&mut self, report: &v1::StepReport, travels: &Travels) -> String {
        let mut text = String::new();
        let columns = self.columns.get_or_insert_with(|| {
            text = header(report);
            report.obstacles.keys().take(MOST).cloned().collect()
        });
        text.push_str(&format!("{:>4} {:>4}", report.step, report.increment));
        for name in columns.iter() {
            let force = report.obstacles.get(name).map(|obstacle| {
                let force = travels.force(name, obstacle);
                with_error(force, obstacle.force_error)
            });
            let width = width(name);
            text.push_str(&format!("  {:>width$}", force.unwrap_or_default()));
        }
        let error = report.error_estimate.map(percent).unwrap_or_default();
        let seconds = report.seconds.unwrap_or_default().total;
        text.push_str(&format!("  {error:>7}"));
        if !report.obstacles.is_empty() {
            text.push_str(&format!(" {:>8}", report.active_vertices));
        }
        text.push_str(&format!(" {seconds:>8.3}  {}", remarks(report)));
        text.truncate(text.trim_end().len());
        text.push('\n');
        text
    }
}

/// At least as wide as a force, and as the name.
fn width(name: &str) -> usize {
    one_line(name).chars().count().max(WIDTH)
}

fn header(report: &v1::StepReport) -> String {
    let mut text = String::new();
    if !report.obstacles.is_empty() {
        text.push_str("force of each obstacle along its travel, its size where it stands still\n");
    }
    let hidden = report.obstacles.len().saturating_sub(MOST);
    if hidden > 0 {
        text.push_str(&format!(
            "{hidden} more obstacles are in the results but not in this table\n"
        ));
    }
    text.push_str("step incr");
    for name in report.obstacles.keys().take(MOST) {
        let width = width(name);
        text.push_str(&format!("  {:>width$}", one_line(name)));
    }
    text.push_str("    error");
    if !report.obstacles.is_empty() {
        text.push_str(" touching");
    }
    text.push_str("  seconds\n");
    text
}

/// What is not as usual.
fn remarks(report: &v1::StepReport) -> String {
    let mut remarks = Vec::new();
    if report.termination() != v1::Termination::Converged {
        remarks.push(words::termination(report.termination()).replace('_', " "));
    }
    remarks.extend(words::cause(report.cause()).map(|cause| cause.replace('_', " ")));
    let mut kinds: Vec<String> = Vec::new();
    for warning in &report.warnings {
        let kind = one_line(&warning.kind).replace('_', " ");
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    remarks.append(&mut kinds);
    remarks.join(", ")
}
