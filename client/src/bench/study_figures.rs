//! The diagrams of a study, family by family: one curve a choice.

use super::answer::answers;
use super::chart::{Curve, Diagram, Kind, Point, State, Stroke};
use super::family::{Level, Quantity};
use super::figures::{Figure, Results, UNKNOWNS, state};
use super::row::Row;
use super::strand::{Strand, strands};
use super::study::{Measure, Scope, Study};

/// A question, its figures and the sentences that follow from the rows.
#[derive(Clone, Debug)]
pub(crate) struct Inquiry {
    pub(crate) study: &'static Study,
    pub(crate) figures: Vec<Figure>,
    pub(crate) answers: Vec<String>,
}

/// Studies that have rows.
pub(crate) fn inquiries(results: &Results, studies: &[&'static Study]) -> Vec<Inquiry> {
    let inquiries = studies.iter().map(|study| Inquiry {
        study,
        figures: figures(results, study),
        answers: answers(results, study),
    });
    let told = |one: &Inquiry| !(one.figures.is_empty() && one.answers.is_empty());
    inquiries.filter(told).collect()
}

fn figures(results: &Results, study: &Study) -> Vec<Figure> {
    let scopes = study.scopes.iter();
    let diagrams = scopes.flat_map(|scope| {
        let strands = strands(results, study, scope);
        let drawn = match study.measure {
            Measure::SameMesh | Measure::OtherProblem => costs(scope, &strands),
            Measure::OneMesh => Vec::new(),
            Measure::SameError => errors(results, scope, &strands),
            Measure::Tolerance => tolerances(scope, &strands),
        };
        drawn
            .into_iter()
            .map(|(name, diagram)| {
                (
                    format!("study-{}-{}-{name}", study.name, scope.family),
                    diagram,
                )
            })
            .collect::<Vec<_>>()
    });
    diagrams
        .filter(|(_, diagram)| !diagram.is_empty())
        .map(|(name, mut diagram)| {
            diagram.footer = results.footer(None, &[]);
            let svg = diagram.svg();
            Figure { name, svg }
        })
        .collect()
}

type Named = (String, Diagram);

fn diagram(title: String, x: (Kind, &str), y: (Kind, &str), curves: Vec<Curve>) -> Diagram {
    Diagram {
        title,
        x: (x.0, x.1.to_owned()),
        y: (y.0, y.1.to_owned()),
        curves,
        level: None,
        footer: Vec::new(),
    }
}

/// One curve a choice; refused ones keep their colour and stay empty.
fn curves(strands: &[Strand<'_>], point: impl Fn(&Row) -> Option<Point>) -> Vec<Curve> {
    let known = |strand: &Strand<'_>| strand.is_known();
    strands
        .iter()
        .map(|strand| Curve {
            label: strand.label.to_owned(),
            stroke: Stroke::Solid,
            points: match known(strand) {
                true => strand.rows.iter().filter_map(|row| point(row)).collect(),
                false => Vec::new(),
            },
        })
        .collect()
}

fn at(row: &Row, x: f64, y: f64) -> Option<Point> {
    let (state, name) = (state(row, false), row.case.level.to_string());
    let y = match state {
        State::Failed => None,
        State::Good | State::Uncertain => Some(y),
    };
    (x > 0.0).then_some(Point { x, y, state, name })
}

/// Applications and seconds over unknowns.
fn costs(scope: &Scope, strands: &[Strand<'_>]) -> Vec<Named> {
    let applications = curves(strands, |row| {
        at(row, row.unknowns(), row.numbers.applications as f64)
    });
    let seconds = curves(strands, |row| at(row, row.unknowns(), row.numbers.seconds));
    let across = (Kind::Logarithmic, UNKNOWNS);
    vec![
        (
            "applications".to_owned(),
            diagram(
                format!("{}: applications of the preconditioner", scope.family),
                across,
                (Kind::Logarithmic, "applications"),
                applications,
            ),
        ),
        (
            "seconds".to_owned(),
            diagram(
                format!("{}: time", scope.family),
                across,
                (
                    Kind::Logarithmic,
                    "wall time of the solve, cold process (s)",
                ),
                seconds,
            ),
        ),
    ]
}

const TIME: &str = "wall time of the solve, cold process (s)";

/// Each error over seconds, and over unknowns.
fn errors(results: &Results, scope: &Scope, strands: &[Strand<'_>]) -> Vec<Named> {
    let Some(family) = scope.family() else {
        return Vec::new();
    };
    let each = family.quantities.iter().flat_map(|&quantity| {
        let limit = results.references.limit(family.name, quantity);
        let limit = limit.filter(|_| quantity.exact_norm().is_none());
        let uncertainty = limit.map_or(0.0, |limit| limit.relative());
        let over = |x: fn(&Row) -> f64| {
            curves(strands, |row| {
                let mut point = at(row, x(row), row.error(quantity).unwrap_or(f64::NAN))?;
                if point.y.is_some_and(|error| error < uncertainty) {
                    point.state = State::Uncertain;
                }
                let drawable = point.y.is_none_or(f64::is_finite);
                drawable.then_some(point)
            })
        };
        let title = |against: &str| {
            format!(
                "{}: error of the {} against {against}",
                scope.family,
                quantity.label()
            )
        };
        let up = (Kind::Logarithmic, "relative error");
        [
            (
                format!("{}-seconds", quantity.name()),
                diagram(
                    title("time"),
                    (Kind::Logarithmic, TIME),
                    up,
                    over(|row| row.numbers.seconds),
                ),
            ),
            (
                format!("{}-unknowns", quantity.name()),
                diagram(
                    title("unknowns"),
                    (Kind::Logarithmic, UNKNOWNS),
                    up,
                    over(Row::unknowns),
                ),
            ),
        ]
    });
    each.collect()
}

/// Error over seconds and iterations over tolerance, one curve a mesh and choice.
fn tolerances(scope: &Scope, strands: &[Strand<'_>]) -> Vec<Named> {
    let Some(&quantity) = scope.family().and_then(|family| family.quantities.first()) else {
        return Vec::new();
    };
    let mut levels: Vec<Level> = strands
        .iter()
        .flat_map(|strand| &strand.rows)
        .map(|row| row.case.level)
        .collect();
    levels.sort_unstable();
    levels.dedup();
    let each = |point: fn(&Row, Quantity) -> Option<Point>| -> Vec<Curve> {
        let known = strands.iter().filter(|strand| strand.is_known());
        let known: Vec<&Strand<'_>> = known.collect();
        let pairs = levels
            .iter()
            .flat_map(|&level| known.iter().map(move |strand| (level, *strand)));
        pairs
            .map(|(level, strand)| tolerance_curve(strand, level, |row| point(row, quantity)))
            .filter(|curve| curve.points.len() > 2 || curve.label.contains('='))
            .collect()
    };
    let title = |against: &str| {
        format!(
            "{}: error of the {} against {against}",
            scope.family,
            quantity.label()
        )
    };
    let up = (Kind::Logarithmic, "relative error");
    let over_time = each(|row, quantity| at(row, row.numbers.seconds, row.error(quantity)?));
    let over_tolerance = each(|row, quantity| at(row, row.case.tolerance, row.error(quantity)?));
    vec![
        (
            format!("{}-seconds", quantity.name()),
            diagram(title("time"), (Kind::Logarithmic, TIME), up, over_time),
        ),
        (
            format!("{}-tolerance", quantity.name()),
            diagram(
                title("the tolerance"),
                (Kind::Logarithmic, "tolerance of the residuals"),
                up,
                without_own_tolerance(over_tolerance),
            ),
        ),
    ]
}

/// Curves of choices that do not name their tolerance.
fn without_own_tolerance(mut curves: Vec<Curve>) -> Vec<Curve> {
    curves.retain(|curve| !curve.label.contains('='));
    curves
}

fn tolerance_curve(
    strand: &Strand<'_>,
    level: Level,
    point: impl Fn(&Row) -> Option<Point>,
) -> Curve {
    let named = |row: &&Row| -> Option<Point> {
        let mut point = point(row)?;
        point.name = match strand.label.contains('=') {
            true => String::new(),
            false => format!("{:e}", row.case.tolerance),
        };
        Some(point)
    };
    let rows = strand.rows.iter().filter(|row| row.case.level == level);
    Curve {
        label: format!("{level}, {}", strand.label),
        stroke: Stroke::Solid,
        points: rows.filter_map(named).collect(),
    }
}
