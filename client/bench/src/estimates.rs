//! What the solver estimates of its own error, beside the true error.

use crate::axis::SIZE;
use crate::chart::{Curve, Diagram, Kind, Point, State, Stroke};
use crate::family::{Family, Quantity};
use crate::results::Results;
use crate::row::Row;

/// Estimate and true error over unknowns, at the first tolerance of a family's
/// default method; empty without estimates. Scenes with contact compare the
/// force of the obstacle, the others the energy norm with the H1 seminorm: for an
/// incompressible body of one material the two differ by a factor near one.
pub(crate) fn diagram(results: &Results, family: &'static Family) -> Diagram {
    let truth = if family.quantities.contains(&Quantity::Force) {
        Quantity::Force
    } else {
        Quantity::DisplacementH1
    };
    let curve = results.curves_of(family).into_iter().next();
    let curve = curve.unwrap_or_default();
    let label = if truth == Quantity::Force {
        "estimated error of the contact force"
    } else {
        "estimated error (energy norm)"
    };
    let estimate = points(&curve, |row| {
        if truth == Quantity::Force {
            row.numbers.force_estimate
        } else {
            row.numbers.estimate
        }
    });
    let found = if estimate.is_empty() {
        Vec::new()
    } else {
        points(&curve, |row| row.error(truth))
    };
    let named = |label: String, stroke, points| Curve {
        label,
        stroke,
        points,
    };
    Diagram {
        title: format!("{}: estimated and true error", family.name),
        x: (Kind::Logarithmic, SIZE.label.to_owned()),
        y: (Kind::Logarithmic, "relative error".to_owned()),
        curves: vec![
            named(label.to_owned(), Stroke::Solid, estimate),
            named(
                format!("true error of the {}", truth.label()),
                Stroke::Dashed,
                found,
            ),
        ],
        level: None,
        footer: results.footer(None, &[]),
    }
}

fn points(curve: &[&Row], value: impl Fn(&Row) -> Option<f64>) -> Vec<Point> {
    let good = curve.iter().filter(|row| row.converged());
    good.filter_map(|row| {
        let (y, name) = (Some(value(row)?), row.case.level.to_string());
        let (x, state) = (row.unknowns(), State::Good);
        Some(Point {
            x,
            y,
            state,
            name,
            spread: None,
        })
    })
    .collect()
}
