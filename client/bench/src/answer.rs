//! Tables that answer the questions of the studies from their rows.
//!
//! Equal mesh: seconds of each choice over those of the first one, which is what
//! the plan takes by itself. Equal error: seconds interpolated along each choice's
//! curve, both axes logarithmic, at the smallest error that two choices reach.
//! Limits: see [`limits`]. Tolerances: seconds and error over those of the tightest.

use crate::axis::SIZE;
use crate::extremes;
use crate::family::Quantity;
use crate::limits;
use crate::results::Results;
use crate::row::Row;
use crate::strand::{Strand, strands};
use crate::study::{Measure, Scope, Study};
use crate::table::{Column, Table};
use crate::text::{NOTHING, in_seconds, times, told};

/// The table of a study; without lines where nothing was measured.
pub(crate) fn table(results: &Results, study: &Study) -> Table {
    let scopes = study.scopes.iter();
    let scopes = scopes.map(|scope| (scope, strands(results, study, scope)));
    match study.measure {
        Measure::SameMesh | Measure::OneMesh => {
            let lines = scopes.flat_map(|(_, strands)| lines(&strands));
            Table::new(SAME_MESH).with(lines.map(|line| line.cost()))
        }
        Measure::SameError => {
            let mut labels: Vec<&str> = study.choices.iter().map(|choice| choice.label).collect();
            labels.dedup();
            let columns = labels.into_iter().map(Column::Number);
            let columns = SAME_ERROR.into_iter().chain(columns);
            let lines = scopes.flat_map(|(scope, strands)| same_error(scope, &strands));
            Table::new(columns.collect::<Vec<_>>()).with(lines)
        }
        Measure::Limits => {
            let lines = scopes.flat_map(|(scope, strands)| limits::lines(results, scope, &strands));
            Table::new(limits::COLUMNS).with(lines)
        }
        Measure::Extremes => extremes::table(&results.findings),
        Measure::Tolerance => {
            let lines = scopes.flat_map(|(_, strands)| lines(&strands));
            Table::new(TOLERANCES).with(lines.filter_map(|line| line.bargain()))
        }
    }
}

/// A run of a choice, and the tightest of the first choice on the same mesh.
struct Line<'a> {
    choice: &'static str,
    row: &'a Row,
    first: Option<&'a Row>,
}

/// Mesh by mesh, choice by choice, the loosest tolerance first.
fn lines<'a>(strands: &[Strand<'a>]) -> Vec<Line<'a>> {
    let first = |row: &Row| {
        let mut rows = strands.first()?.converged();
        rows.rfind(|first| first.case.level == row.case.level)
    };
    let each = strands.iter().flat_map(|strand| {
        let rows = strand.rows.iter();
        rows.map(|row| Line {
            choice: strand.label,
            row,
            first: first(row),
        })
    });
    let mut lines: Vec<Line<'a>> = each.collect();
    lines.sort_by_key(|line| line.row.case.level);
    lines
}

const SAME_MESH: [Column; 7] = [
    Column::Group("scene"),
    Column::Group("mesh"),
    Column::Group("unknowns"),
    Column::Text("choice"),
    Column::Number("seconds"),
    Column::Number("over the first choice"),
    Column::Number("applications"),
];

const TOLERANCES: [Column; 7] = [
    Column::Group("scene"),
    Column::Group("mesh"),
    Column::Text("tolerance"),
    Column::Number("seconds"),
    Column::Number("over the tightest"),
    Column::Number("relative error"),
    Column::Number("over the tightest"),
];

impl Line<'_> {
    fn cost(&self) -> [String; 7] {
        let [seconds, ratio] = self.seconds();
        let applications = Some(self.row.numbers.applications).filter(|count| *count > 0);
        [
            self.row.case.family.name.to_owned(),
            self.row.case.level.to_string(),
            told((SIZE.of)(self.row), |count| count.to_string()),
            self.choice.to_owned(),
            seconds,
            ratio,
            told(applications, |count| count.to_string()),
        ]
    }

    /// None for a family without errors.
    fn bargain(&self) -> Option<[String; 7]> {
        let case = &self.row.case;
        let quantity = *case.family.quantities.first()?;
        let error = self.row.error(quantity);
        let least = self.first.and_then(|first| first.error(quantity));
        let [seconds, ratio] = self.seconds();
        let tolerance = match case.method.overrides().next() {
            None => format!("{:e}", case.tolerance),
            Some(_) => self.choice.to_owned(),
        };
        Some([
            case.family.name.to_owned(),
            case.level.to_string(),
            tolerance,
            seconds,
            ratio,
            told(error, |error| format!("{error:.2e}")),
            told(error.zip(least), |(error, least)| {
                format!("{:.2}", error / least)
            }),
        ])
    }

    /// Its seconds, or what came of it, and their ratio to those of the first.
    fn seconds(&self) -> [String; 2] {
        let seconds = self.row.numbers.seconds;
        let ratio = |first: &Row| times(seconds / first.numbers.seconds);
        if self.row.converged() {
            [in_seconds(seconds), told(self.first, ratio)]
        } else {
            [self.row.outcome.spoken(), NOTHING.to_owned()]
        }
    }
}

const SAME_ERROR: [Column; 3] = [
    Column::Group("scene"),
    Column::Text("error of the"),
    Column::Number("relative error"),
];

/// A line a quantity: the seconds that each choice takes to the same error.
fn same_error(scope: &Scope, strands: &[Strand<'_>]) -> Vec<Vec<String>> {
    let quantities = scope.family().map_or(&[][..], |family| family.quantities);
    let line = |&quantity: &Quantity| {
        let curves: Vec<Curve> = strands.iter().map(|one| curve(one, quantity)).collect();
        let goal = shared_error(&curves)?;
        let head = [scope.family, quantity.label()].map(str::to_owned);
        let seconds = strands.iter().zip(&curves).map(|(strand, curve)| {
            seconds_to(curve, goal).unwrap_or_else(|| format!("{NOTHING} ({})", strand.fate()))
        });
        let cells = head.into_iter().chain([format!("{goal:.1e}")]);
        Some(cells.chain(seconds).collect())
    };
    quantities.iter().filter_map(line).collect()
}

/// Relative errors and the seconds that they take, coarsest mesh first.
type Curve = Vec<(f64, f64)>;

fn curve(strand: &Strand<'_>, quantity: Quantity) -> Curve {
    let point = |row: &Row| Some((row.error(quantity)?, row.numbers.seconds));
    strand.converged().filter_map(point).collect()
}

/// The seconds that a curve takes to an error; none without a point.
fn seconds_to(curve: &[(f64, f64)], goal: f64) -> Option<String> {
    let &(coarsest, least) = curve.first()?;
    Some(match seconds_at(curve, goal) {
        Some(seconds) => in_seconds(seconds),
        None if coarsest < goal => format!("≤ {} (error {coarsest:.1e})", in_seconds(least)),
        None => "not reached".to_owned(),
    })
}

/// The smallest error that two curves reach.
fn shared_error(curves: &[Curve]) -> Option<f64> {
    let least = |curve: &Curve| curve.iter().map(|point| point.0).reduce(f64::min);
    let mut best: Vec<f64> = curves.iter().filter_map(least).collect();
    best.sort_by(f64::total_cmp);
    best.get(1).copied()
}

/// Seconds at an error, between two neighbouring points of a curve.
fn seconds_at(curve: &[(f64, f64)], goal: f64) -> Option<f64> {
    if let Some(exact) = curve.iter().find(|point| point.0.total_cmp(&goal).is_eq()) {
        return Some(exact.1);
    }
    let pairs = curve.iter().zip(curve.iter().skip(1));
    let mut around = pairs.filter(|(a, b)| a.0 > goal && b.0 <= goal);
    let (a, b) = around.next()?;
    let part = (a.0 / goal).ln() / (a.0 / b.0).ln();
    Some((a.1.ln() + part * (b.1 / a.1).ln()).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Outcome;
    use crate::samples::{results, row};
    use crate::study::find;

    fn answer(study: &str, rows: Vec<Row>) -> Vec<Vec<String>> {
        table(&results(rows), find(study).unwrap()).rows().to_vec()
    }

    #[test]
    fn choices_are_compared_with_the_first_one_mesh_by_mesh() {
        let run = |level, keys, seconds, applications| {
            let mut row = row("cube-bend", level, keys, seconds);
            row.numbers.applications = applications;
            row
        };
        let mut slow = run("n10", "p1_solver=amg", 5.0, 0);
        slow.outcome = Outcome::TimeLimit;
        let rows = vec![
            run("n6", "auto", 0.1, 20),
            run("n10", "auto", 1.0, 25),
            run("n10", "p1_solver=cholesky", 0.77, 24),
            slow,
            run("n16", "p1_solver=amg", 3.0, 30),
        ];
        let found = answer("p1-solver", rows);
        let line = |text: &str| -> Vec<String> {
            let cells = ["cube-bend"].into_iter().chain(text.split(", "));
            cells.map(str::to_owned).collect()
        };
        assert_eq!(
            found,
            [
                line("n6, 123, chosen by the plan, 0.100 s, 1.0\u{a0}×, 20"),
                line("n10, 123, chosen by the plan, 1.00 s, 1.0\u{a0}×, 25"),
                line("n10, 123, sparse Cholesky, 0.770 s, 0.77\u{a0}×, 24"),
                line("n10, 123, algebraic multigrid, time limit, –, –"),
                line("n16, 123, algebraic multigrid, 3.00 s, –, 30"),
            ]
        );
        assert!(answer("saddle", Vec::new()).is_empty());
    }

    #[test]
    fn elements_are_compared_at_the_smallest_error_that_two_reach() {
        let run = |level, keys, seconds, error| {
            let mut row = row("A1m", level, keys, seconds);
            row.errors = vec![(Quantity::PressureL2, error)];
            row
        };
        let mut results = results(vec![
            run("n4", "auto", 1.0, 1e-2),
            run("n6", "auto", 100.0, 1e-4),
        ]);
        results.recorded = vec![
            run("n4", "element=mini", 1.0, 1e-1),
            run("n6", "element=mini", 9.0, 1e-3),
        ];
        let line = ["A1m", "pressure (L2 norm)", "1.0e-3"];
        let absent = "– (not measured)";
        let found = table(&results, find("element").unwrap());
        let seconds = ["10.0 s", absent, "9.00 s", absent];
        assert_eq!(found.rows(), [[&line[..], &seconds].concat()]);
    }

    #[test]
    fn a_tolerance_is_judged_by_the_error_of_the_tightest() {
        let run = |keys, tolerance, error| {
            let mut row = row("hertz-plane", "l2", keys, 0.5);
            row.case.tolerance = tolerance;
            row.errors = vec![(Quantity::Force, error)];
            row
        };
        let rows = vec![
            run("auto", 1e-4, 0.0202),
            run("auto", 1e-2, 0.04),
            run("auto", 1e-8, 0.02),
            run("tolerance=discretisation", 1e-10, 0.021),
        ];
        let found = answer("tolerance", rows);
        let column = |place: usize| -> Vec<&str> {
            let cells = found.iter().map(|line| line[place].as_str());
            cells.collect()
        };
        let names = ["1e-2", "1e-4", "1e-8", "tolerance = discretisation"];
        assert_eq!(column(2), names);
        assert_eq!(column(5), ["4.00e-2", "2.02e-2", "2.00e-2", "2.10e-2"]);
        assert_eq!(column(6), ["2.00", "1.01", "1.00", "1.05"]);
    }

    #[test]
    fn seconds_are_interpolated_along_a_power() {
        // Error 1/t: exact on logarithmic axes.
        let curve = [(1.0, 1.0), (0.1, 10.0), (0.01, 100.0)];
        assert!((seconds_at(&curve, 0.05).unwrap() - 20.0).abs() < 1e-9);
        assert_eq!(seconds_at(&curve, 0.001), None);
        assert_eq!(seconds_at(&curve, 1.0), Some(1.0));
    }

    #[test]
    fn a_curve_below_the_error_is_told_by_its_coarsest_mesh() {
        let curve = [(1e-3, 2.0), (1e-4, 9.0)];
        let told = |goal| seconds_to(&curve, goal).unwrap();
        assert_eq!(told(5e-5), "not reached");
        assert_eq!(told(1e-2), "≤ 2.00 s (error 1.0e-3)");
        assert_eq!(seconds_to(&[], 1e-2), None);
    }

    #[test]
    fn the_shared_error_is_one_that_two_curves_reach() {
        let fine = vec![(1e-2, 1.0), (1e-4, 9.0)];
        let coarse = vec![(1e-1, 1.0), (1e-3, 9.0)];
        let curves = [fine, coarse, Vec::new()];
        assert_eq!(shared_error(&curves), Some(1e-3));
        assert_eq!(shared_error(&curves[..1]), None);
    }
}
