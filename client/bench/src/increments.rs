//! What an increment of a load takes, over unknowns: quadratic programs, and
//! applications of the preconditioner in all of them. The mean of a run.

use crate::axis::SIZE;
use crate::chart::{Curve, Diagram, Kind, Point, State, Stroke};
use crate::family::Family;
use crate::measure::Numbers;
use crate::results::Results;
use crate::row::Row;

/// The default method of a family at its first tolerance; empty for scenes of one
/// increment.
pub(crate) fn diagram(results: &Results, family: &'static Family) -> Diagram {
    let curve = results.curves_of(family).into_iter().next();
    let curve = curve.unwrap_or_default();
    let curves = [
        ("applications of the preconditioner", applications as Count),
        ("quadratic programs", programs as Count),
    ];
    let curves = curves.map(|(label, count)| Curve {
        label: label.to_owned(),
        stroke: Stroke::Solid,
        points: points(&curve, count),
    });
    Diagram {
        title: format!("{}: work of an increment", family.name),
        x: (Kind::Logarithmic, SIZE.label.to_owned()),
        y: (Kind::Logarithmic, "count an increment (mean)".to_owned()),
        curves: curves.into(),
        level: None,
        footer: results.footer(None, &[]),
    }
}

type Count = fn(&Numbers) -> i64;

fn applications(numbers: &Numbers) -> i64 {
    numbers.applications
}

fn programs(numbers: &Numbers) -> i64 {
    numbers.programs
}

fn points(curve: &[&Row], count: Count) -> Vec<Point> {
    let good = curve.iter().filter(|row| row.converged());
    good.filter_map(|row| {
        let name = row.case.level.to_string();
        let y = an_increment(&row.numbers, count)?;
        let (x, state) = (row.unknowns(), State::Good);
        Some(Point {
            x,
            y: Some(y),
            state,
            name,
            spread: None,
        })
    })
    .collect()
}

/// The mean over increments; none for a single one.
fn an_increment(numbers: &Numbers, count: Count) -> Option<f64> {
    (numbers.increments > 1).then(|| count(numbers) as f64 / numbers.increments as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_those_of_one_increment_of_several() {
        let numbers = |increments| Numbers {
            increments,
            programs: 34,
            applications: 1021,
            ..Numbers::default()
        };
        let ten = numbers(10);
        let found = [applications as Count, programs].map(|count| an_increment(&ten, count));
        assert_eq!(found, [Some(102.1), Some(3.4)]);
        assert_eq!(an_increment(&numbers(1), programs), None);
    }
}
