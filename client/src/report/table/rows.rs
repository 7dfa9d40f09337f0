//! One row an increment, written when it is done.

use signorini_client::study::asked;
use signorini_proto::{v1, words};

use super::fluid::verdict;
use crate::report::travel::Travels;
use crate::terminal::text::{number, one_line, percent, with_error};

/// Obstacles that have a column: more would not fit on a line.
const MOST: usize = 4;
/// Characters of a force, alone and with its error.
const ALONE: usize = 12;
const WITH_ERROR: usize = 20;

/// The table under construction.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    /// What has a column, once the header is written.
    columns: Option<Columns>,
    /// Goals whose errors are told with some increments.
    bounded: Vec<String>,
}

impl Rows {
    /// Of the results of a scene.
    pub(crate) fn of(scene: &v1::Scene) -> Self {
        Self {
            columns: None,
            bounded: asked::bounded(scene),
        }
    }

    /// The row of an increment, below the header when it is the first.
    pub(crate) fn row(&mut self, report: &v1::StepReport, travels: &Travels) -> String {
        let mut text = String::new();
        let columns = self.columns.get_or_insert_with(|| {
            let columns = Columns::of(report, (travels, &self.bounded));
            text = columns.header(report);
            columns
        });
        text.push_str(&columns.row(report, travels));
        text
    }
}

/// What has a column, by the first increment.
#[derive(Debug)]
struct Columns {
    /// Obstacles or, of a scene without any, supports that move.
    forces: Vec<Force>,
    /// Whether the error of the mesh is estimated.
    has_error: bool,
}

/// A column of forces.
#[derive(Debug)]
struct Force {
    name: String,
    /// The name, between bars where the magnitude is told.
    label: String,
    width: usize,
}

impl Force {
    fn new(name: &str, is_along: bool, own: usize) -> Self {
        let label = if is_along {
            one_line(name).into_owned()
        } else {
            format!("|{}|", one_line(name))
        };
        Self {
            name: name.to_owned(),
            width: label.chars().count().max(own),
            label,
        }
    }
}

impl Columns {
    fn of(report: &v1::StepReport, (travels, bounded): (&Travels, &[String])) -> Self {
        let is_bounded = |name: &str| {
            let own = format!("force.{name}.");
            bounded.iter().any(|goal| goal.starts_with(&own))
        };
        let mut forces: Vec<_> = report
            .obstacles
            .keys()
            .map(|name| {
                let has_error = is_bounded(name) || travels.force_error(name, report).is_some();
                let own = if has_error { WITH_ERROR } else { ALONE };
                Force::new(name, travels.has_travelled(name), own)
            })
            .collect();
        if forces.is_empty() {
            let moved = travels.supports();
            forces = moved
                .map(|name| Force::new(name, travels.has_moved(name), ALONE))
                .collect();
        }
        forces.truncate(MOST);
        Self {
            forces,
            has_error: report.error_estimate.is_some(),
        }
    }

    fn header(&self, report: &v1::StepReport) -> String {
        let mut text = String::new();
        if !self.forces.is_empty() {
            let of = if report.obstacles.is_empty() {
                "support"
            } else {
                "obstacle"
            };
            text.push_str(&format!(
                "force of each {of}: component along its motion; |NAME|: magnitude, of one that rests\n"
            ));
        }
        if !report.obstacles.is_empty() {
            text.push_str("touching: points of the surface in contact (vertices and edges)\n");
        }
        let hidden = report.obstacles.len().saturating_sub(MOST);
        if hidden > 0 {
            text.push_str(&format!(
                "{hidden} more obstacles are in the results but not in this table\n"
            ));
        }
        text.push_str("step incr");
        for Force { label, width, .. } in &self.forces {
            text.push_str(&format!("  {label:>width$}"));
        }
        if self.has_error {
            text.push_str("    error");
        }
        if !report.obstacles.is_empty() {
            text.push_str(" touching");
        }
        text.push_str("  seconds\n");
        text
    }

    fn row(&self, report: &v1::StepReport, travels: &Travels) -> String {
        let mut text = format!("{:>4} {:>4}", report.step, report.increment);
        for Force { name, width, .. } in &self.forces {
            let force = force(report, travels, name).unwrap_or_default();
            text.push_str(&format!("  {force:>width$}"));
        }
        if self.has_error {
            let error = report.error_estimate.map(percent).unwrap_or_default();
            text.push_str(&format!("  {error:>7}"));
        }
        if !report.obstacles.is_empty() {
            text.push_str(&format!(" {:>8}", report.active_vertices));
        }
        let seconds = report.seconds.unwrap_or_default().total;
        text.push_str(&format!(" {seconds:>8.3}  {}", remarks(report)));
        text.truncate(text.trim_end().len());
        text.push('\n');
        text
    }
}

/// Of an obstacle or a support of that name.
fn force(report: &v1::StepReport, travels: &Travels, name: &str) -> Option<String> {
    let of_obstacle = report.obstacles.get(name).map(|obstacle| {
        let force = travels.force(name, obstacle);
        with_error(force, travels.force_error(name, report))
    });
    let of_support = || {
        report
            .supports
            .get(name)
            .map(|one| number(travels.reaction(name, one)))
    };
    of_obstacle.or_else(of_support)
}

/// What is not as usual.
fn remarks(report: &v1::StepReport) -> String {
    let mut remarks = Vec::new();
    if report.termination() != v1::Termination::Converged {
        remarks.push(words::termination(report.termination()).replace('_', " "));
    }
    remarks.extend(words::cause(report.cause()).map(|cause| cause.replace('_', " ")));
    let leaks = report.fluids.iter();
    let leaks = leaks.filter(|(_, fluid)| fluid.tightness() == v1::Tightness::Leaks);
    remarks.extend(leaks.map(|(name, fluid)| format!("{} {}", one_line(name), verdict(fluid))));
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
