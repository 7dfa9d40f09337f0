//! The table of a study of discretisations: errors mesh by mesh, and the limits
//! that each choice tends to.
//!
//! Errors are those against the limit of the reference values, one for all
//! choices. The limit of a choice is extrapolated from its own rows: where two
//! agree within their uncertainties, the choices solve the same problem.

use crate::family::{Level, Quantity};
use crate::limit::{Limit, Sample, extrapolate};
use crate::results::Results;
use crate::row::Row;
use crate::strand::Strand;
use crate::study::Scope;
use crate::table::Column;
use crate::text::{in_seconds, rounded, told};

/// Titles of [`lines`]: all families of such a study have the same meshes.
pub(crate) const COLUMNS: [Column; 10] = [
    Column::Group("scene"),
    Column::Group("error of the"),
    Column::Text("choice"),
    Column::Number("l1"),
    Column::Number("l2"),
    Column::Number("l3"),
    Column::Number("l4"),
    Column::Number("own limit"),
    Column::Number("plus or minus"),
    Column::Number("seconds, finest"),
];

/// A line a quantity and choice; quantities with an exact norm have no limit.
pub(crate) fn lines(results: &Results, scope: &Scope, strands: &[Strand<'_>]) -> Vec<Vec<String>> {
    let quantities = scope.family().map_or(&[][..], |family| family.quantities);
    let measured = |strand: &&Strand<'_>| !strand.rows.is_empty();
    let each = quantities.iter().flat_map(|&quantity| {
        let strands = strands.iter().filter(measured);
        strands.map(move |strand| line(results, scope, strand, quantity))
    });
    each.collect()
}

fn line(results: &Results, scope: &Scope, strand: &Strand<'_>, quantity: Quantity) -> Vec<String> {
    let mut cells = vec![
        scope.family.to_owned(),
        quantity.label().to_owned(),
        strand.label.to_owned(),
    ];
    let levels = scope.levels(scope.full);
    cells.extend(levels.iter().map(|level| error(strand, *level, quantity)));
    let limit = limit(results, scope, strand, quantity);
    cells.push(told(limit, |limit| rounded(limit.value).to_string()));
    cells.push(told(limit, |limit| format!("{:.0e}", limit.uncertainty)));
    let finest = strand.converged().next_back();
    cells.push(told(finest, |row| in_seconds(row.numbers.seconds)));
    cells
}

/// The error on a mesh, or what came of the run.
fn error(strand: &Strand<'_>, level: Level, quantity: Quantity) -> String {
    let mut rows = strand.rows.iter();
    let row = rows.find(|row| row.case.level == level);
    let text = |row: &Row| {
        if row.converged() {
            told(row.error(quantity), |error| format!("{error:.1e}"))
        } else {
            row.outcome.spoken()
        }
    };
    told(row, |row| text(row))
}

/// What the values of a choice tend to; none on fewer than three meshes.
fn limit(
    results: &Results,
    scope: &Scope,
    strand: &Strand<'_>,
    quantity: Quantity,
) -> Option<Limit> {
    let sample = |row: &Row| {
        let h = results.references.size(scope.family, row.case.level)?;
        let mut values = row.numbers.values.iter();
        let value = values.find(|value| value.0 == quantity)?.1;
        Some(Sample { h, value })
    };
    let samples: Vec<Sample> = strand.converged().filter_map(sample).collect();
    extrapolate(&samples)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::table;
    use crate::samples::{results, row};
    use crate::study::find;

    #[test]
    fn each_choice_has_its_errors_and_its_own_limit() {
        let run = |level: &str, keys, value| {
            let mut row = row("hertz-sphere", level, keys, 0.5);
            row.numbers.values = vec![(Quantity::Force, value)];
            row.errors = vec![(Quantity::Force, (value - 1.0_f64).abs())];
            row
        };
        // Sizes of l1 to l4; any three of them tell the order.
        let of = |keys: &'static str, value: fn(f64) -> f64| {
            let sizes = [("l1", 0.1), ("l2", 0.05), ("l3", 0.0333), ("l4", 0.025)];
            sizes.map(|(level, h)| run(level, keys, value(h)))
        };
        let quadratic = of("auto", |h| 1.0 + 3.0 * h * h);
        let hats = of("contact_space=linear", |h| 1.0 - h);
        let rows = quadratic.into_iter().chain(hats).collect();
        let found = table(&results(rows), find("contact-space").unwrap());
        let of_force = |line: &&Vec<String>| line[1] == "contact force";
        let lines: Vec<_> = found.rows().iter().filter(of_force).collect();
        let errors = ["3.0e-2", "7.5e-3", "3.3e-3", "1.9e-3"];
        assert_eq!(lines[0][2], "quadratic");
        assert_eq!(lines[0][3..7], errors);
        assert_eq!((&*lines[1][2], &*lines[1][7]), ("hats", "1"));
        assert_eq!(lines.len(), 2);
    }
}
