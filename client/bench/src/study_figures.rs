//! The diagrams of a study, family by family: one curve a choice.

use crate::answer;
use crate::axis::{Axis, SIZE, TIME, TOLERANCE};
use crate::chart::{Curve, Diagram, Kind, Point, State, Stroke};
use crate::extremes;
use crate::family::{Level, Quantity};
use crate::figures::state;
use crate::picture::Figure;
use crate::results::Results;
use crate::row::Row;
use crate::strand::{Strand, strands};
use crate::study::{Measure, Scope, Study};
use crate::table::Table;

/// A question, its figures and the table that answers it.
#[derive(Clone, Debug)]
pub(crate) struct Inquiry {
    pub(crate) study: &'static Study,
    /// A sentence on the rows as a whole; empty where the table says all.
    pub(crate) remark: String,
    pub(crate) figures: Vec<Figure>,
    pub(crate) answer: Table,
}

/// Studies that have rows.
pub(crate) fn inquiries(results: &Results, studies: &[&'static Study]) -> Vec<Inquiry> {
    let inquiries = studies.iter().map(|study| Inquiry {
        study,
        remark: remark(results, study),
        figures: figures(results, study),
        answer: answer::table(results, study),
    });
    let told = |one: &Inquiry| !(one.figures.is_empty() && one.answer.is_empty());
    inquiries.filter(told).collect()
}

fn remark(results: &Results, study: &Study) -> String {
    if study.measure == Measure::Extremes {
        extremes::remark(&results.findings)
    } else {
        String::new()
    }
}

fn figures(results: &Results, study: &Study) -> Vec<Figure> {
    if study.measure == Measure::Extremes {
        let footer = results.footer(None, &[]);
        return extremes::figure(&results.findings, footer)
            .into_iter()
            .collect();
    }
    let drawn = study.scopes.iter().flat_map(|scope| {
        let strands = strands(results, study, scope);
        let diagrams = match study.measure {
            Measure::SameMesh => costs(scope, &strands),
            Measure::OneMesh | Measure::Extremes => Vec::new(),
            Measure::SameError | Measure::Limits => errors(results, scope, &strands),
            Measure::Tolerance => tolerances(scope, &strands),
        };
        let named = |(name, diagram)| {
            let name = format!("study-{}-{}-{name}", study.name, scope.family);
            (name, diagram)
        };
        diagrams.into_iter().map(named).collect::<Vec<Named>>()
    });
    let drawn = drawn.filter(|(_, diagram)| !diagram.is_empty());
    drawn
        .map(|(name, mut diagram)| {
            diagram.footer = results.footer(None, &[]);
            let svg = diagram.svg();
            Figure { name, svg }
        })
        .collect()
}

/// A diagram and the end of its file name.
type Named = (String, Diagram);

fn diagram(title: String, across: &Axis, up: &str, curves: Vec<Curve>) -> Diagram {
    Diagram {
        title,
        x: (Kind::Logarithmic, across.label.to_owned()),
        y: (Kind::Logarithmic, up.to_owned()),
        curves,
        level: None,
        footer: Vec::new(),
    }
}

/// One curve a choice; refused ones keep their colour and stay empty.
fn curves(strands: &[Strand<'_>], point: impl Fn(&Row) -> Option<Point>) -> Vec<Curve> {
    let points = |strand: &Strand<'_>| {
        if strand.is_known() {
            strand.rows.iter().filter_map(|row| point(row)).collect()
        } else {
            Vec::new()
        }
    };
    let curve = |strand: &Strand<'_>| Curve {
        label: strand.label.to_owned(),
        stroke: Stroke::Solid,
        points: points(strand),
    };
    strands.iter().map(curve).collect()
}

/// The place of a run; a failure has no height.
fn at(row: &Row, across: &Axis, y: f64) -> Option<Point> {
    let (state, name) = (state(row, false), row.case.level.to_string());
    let (x, y) = ((across.of)(row)?, row.converged().then_some(y));
    Some(Point {
        x,
        y,
        state,
        name,
        spread: None,
    })
}

/// Applications and seconds over unknowns.
fn costs(scope: &Scope, strands: &[Strand<'_>]) -> Vec<Named> {
    let over_size = |y: fn(&Row) -> f64| curves(strands, |row| at(row, &SIZE, y(row)));
    let applications = over_size(|row| row.numbers.applications as f64);
    let title = format!("{}: applications of the preconditioner", scope.family);
    let counts = diagram(title, &SIZE, "applications", applications);
    let seconds = over_size(|row| row.numbers.seconds);
    let title = format!("{}: time", scope.family);
    let times = diagram(title, &SIZE, TIME.label, seconds);
    vec![
        ("applications".to_owned(), counts),
        (TIME.name.to_owned(), times),
    ]
}

fn error_diagram(scope: &Scope, quantity: Quantity, across: &Axis, curves: Vec<Curve>) -> Named {
    let title = format!(
        "{}: error of the {} against {}",
        scope.family,
        quantity.label(),
        across.word
    );
    (
        format!("{}-{}", quantity.name(), across.name),
        diagram(title, across, "relative error", curves),
    )
}

/// Each error over seconds, and over unknowns.
fn errors(results: &Results, scope: &Scope, strands: &[Strand<'_>]) -> Vec<Named> {
    let quantities = scope.family().map_or(&[][..], |family| family.quantities);
    let each = quantities.iter().flat_map(|&quantity| {
        let limit = results.references.limit(scope.family, quantity);
        let limit = limit.filter(|_| quantity.exact_norm().is_none());
        let uncertainty = limit.map_or(0.0, |limit| limit.relative());
        [&TIME, &SIZE].map(|across| {
            let point = |row: &Row| {
                let error = row.error(quantity).unwrap_or(f64::NAN);
                let mut point = at(row, across, error)?;
                if point.y.is_some_and(|error| error < uncertainty) {
                    point.state = State::Uncertain;
                }
                point.y.is_none_or(f64::is_finite).then_some(point)
            };
            error_diagram(scope, quantity, across, curves(strands, point))
        })
    });
    each.collect()
}

/// Error over seconds and over tolerance, one curve a mesh and choice.
fn tolerances(scope: &Scope, strands: &[Strand<'_>]) -> Vec<Named> {
    let quantities = scope.family().map_or(&[][..], |family| family.quantities);
    let Some(&quantity) = quantities.first() else {
        return Vec::new();
    };
    let rows = strands.iter().flat_map(|strand| &strand.rows);
    let mut levels: Vec<Level> = rows.map(|row| row.case.level).collect();
    levels.sort_unstable();
    levels.dedup();
    let strands = || strands.iter().filter(|strand| strand.is_known());
    let pairs = || {
        levels
            .iter()
            .flat_map(|&level| strands().map(move |one| (level, one)))
    };
    let over = |across: &Axis| -> Vec<Curve> {
        let point = |row: &Row| at(row, across, row.error(quantity)?);
        let curves = pairs().map(|(level, strand)| tolerance_curve(strand, level, point));
        curves.collect()
    };
    let mut over_time = over(&TIME);
    over_time.retain(|curve| has_own_tolerance(&curve.label) || curve.points.len() > 2);
    let mut over_tolerance = over(&TOLERANCE);
    over_tolerance.retain(|curve| !has_own_tolerance(&curve.label) && curve.points.len() > 2);
    vec![
        error_diagram(scope, quantity, &TIME, over_time),
        error_diagram(scope, quantity, &TOLERANCE, over_tolerance),
    ]
}

/// Whether a choice names its tolerance: it is one point a mesh.
fn has_own_tolerance(label: &str) -> bool {
    label.contains('=')
}

fn tolerance_curve(
    strand: &Strand<'_>,
    level: Level,
    point: impl Fn(&Row) -> Option<Point>,
) -> Curve {
    let named = |row: &&Row| -> Option<Point> {
        let mut point = point(row)?;
        point.name = if has_own_tolerance(strand.label) {
            String::new()
        } else {
            format!("{:e}", row.case.tolerance)
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
