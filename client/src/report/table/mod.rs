//! Plans and results as text for people: a mechanic's words by default, the solver's
//! own behind `--verbose` and in plans.

mod cause;
mod fluid;
mod goals;
mod increment;
mod plan;
mod rows;

use std::collections::HashSet;
use std::fmt::Write as _;

use signorini_proto::v1;

pub(crate) use cause::cause;
pub(crate) use plan::plan;
pub(crate) use rows::Rows;

use crate::report::travel::Travels;
use crate::terminal::text::one_line;

/// The kind of the warning of an obstacle that is away from the body.
pub(crate) const UNTOUCHED: &str = "untouched_obstacle";

/// How much of a result is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Detail {
    /// What a mechanic asks for.
    Short,
    /// And what the solver did.
    Full,
}

/// Lines of a label and a value.
#[derive(Default)]
struct Lines(String);

impl Lines {
    fn add(&mut self, label: &str, value: &str) {
        let (label, value) = (one_line(label), one_line(value));
        // Writing to a string cannot fail.
        let _infallible = writeln!(self.0, "{label:<18} {value}");
    }

    fn add_each<'a>(&mut self, label: &str, values: impl Iterator<Item = (&'a str, String)>) {
        for (name, value) in values {
            self.add(&format!("{label} {name}"), &value);
        }
    }
}

/// The last result of a run in full, and what was doubted before it.
pub(crate) fn results(
    plan: &v1::Plan,
    reports: &[v1::StepReport],
    travels: &Travels,
    detail: Detail,
) -> String {
    let mut lines = Lines::default();
    if let Some(last) = reports.last() {
        lines.add("scene", &plan.name);
        increment::outcome(&mut lines, last);
        increment::loads(&mut lines, last, travels);
        fluid::contacts(&mut lines, last);
        fluid::ties(&mut lines, last);
        fluid::fluids(&mut lines, last);
        goals::goals(&mut lines, last);
        increment::quantities(&mut lines, last);
        if detail == Detail::Full {
            increment::solver(&mut lines, last);
        } else {
            increment::time(&mut lines, last);
        }
    }
    for warning in never_touched(reports)
        .into_iter()
        .chain(earlier_warnings(reports))
    {
        lines.add("warning", &warning);
    }
    if detail == Detail::Full {
        plan::left_out(&mut lines, plan);
    }
    lines.0
}

/// Obstacles that touched nothing in the whole run and of which its last increment says nothing,
/// as those that move away from the body.
pub(crate) fn never_touched(reports: &[v1::StepReport]) -> Vec<String> {
    let Some(last) = reports.last() else {
        return Vec::new();
    };
    let is_told = |name: &str| {
        last.warnings
            .iter()
            .any(|one| one.subject == name && one.kind == UNTOUCHED)
    };
    let names = last.obstacles.keys();
    names
        .filter(|name| !touches(reports, name) && !is_told(name))
        .map(|name| format!("obstacle `{name}` touched nothing in any increment: does it travel towards the body?"))
        .collect()
}

/// Whether an obstacle presses in any increment.
fn touches(reports: &[v1::StepReport], name: &str) -> bool {
    let mut found = reports
        .iter()
        .filter_map(|report| report.obstacles.get(name));
    found.any(|obstacle| obstacle.contact_area > 0.0)
}

/// What was doubted before the last increment and is not in the last one, once each, with the
/// first increment of it.
fn earlier_warnings(reports: &[v1::StepReport]) -> Vec<String> {
    let Some((last, earlier)) = reports.split_last() else {
        return Vec::new();
    };
    let about = |warning: &v1::Warning| (warning.kind.clone(), warning.subject.clone());
    let mut told: HashSet<_> = last.warnings.iter().map(about).collect();
    let mut lines = Vec::new();
    for report in earlier {
        // An obstacle that is waited for is nothing to doubt once it has been met.
        let is_open = |warning: &&v1::Warning| {
            warning.kind != UNTOUCHED || !touches(reports, &warning.subject)
        };
        for warning in report.warnings.iter().filter(is_open) {
            if told.insert(about(warning)) {
                let (step, increment) = (report.step, report.increment);
                let message = &warning.message;
                lines.push(format!("step {step}, increment {increment}: {message}"));
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests;
