//! The seed's own experiments (M. Fortin and A. El Maliki, *A hierarchical
//! preconditioner for Stokes and connected problems*, slides of 23 October
//! 2007), and the runs of this report that come closest. Its tolerance and its
//! machine are not told: its counts compare, its seconds do not.

use csv::StringRecord;

use crate::commented::reader;
use crate::results::Results;
use crate::row::Row;
use crate::table::{Column, Table};
use crate::text::in_seconds;

const EXPERIMENTS: &str = include_str!("seed.csv");

/// A line an experiment: what the seed measured, the same method here, and the
/// default here.
pub(crate) fn table(results: &Results) -> Table {
    let columns = [
        Column::Text("problem of the seed"),
        Column::Text("its method"),
        Column::Text("its steps, seconds (2007)"),
        Column::Text("mesh here"),
        Column::Text("its method here: steps, seconds"),
        Column::Text("default here: steps, seconds"),
    ];
    let experiments = reader(EXPERIMENTS.as_bytes()).into_records().flatten();
    Table::new(columns).with(experiments.filter_map(|one| line(results, &one)))
}

/// None for a line of [`EXPERIMENTS`] that lacks a field, which a test excludes.
fn line(results: &Results, experiment: &StringRecord) -> Option<[String; 6]> {
    let fields: Vec<&str> = experiment.iter().collect();
    let &[problem, method, steps, seconds, scene, level, keys] = fields.as_slice() else {
        return None;
    };
    let same = row(results, (scene, level), keys);
    let default = row(results, (scene, level), "auto");
    let mesh = |row: &Row| format!("{scene} {level}, {:.0} unknowns", row.unknowns());
    Some([
        problem.to_owned(),
        method.to_owned(),
        format!("{steps}, {seconds} s"),
        default.or(same).map_or("not measured".to_owned(), mesh),
        told(same),
        told(default),
    ])
}

/// The tightest row of a scene and level.
fn row<'a>(results: &'a Results, (scene, level): (&str, &str), keys: &str) -> Option<&'a Row> {
    let (level, method) = (level.parse().ok()?, keys.parse().ok()?);
    let rows = results.rows.iter().filter(|row| {
        let case = &row.case;
        case.family.name == scene && case.level == level && case.method == method
    });
    rows.min_by(|a, b| a.case.tolerance.total_cmp(&b.case.tolerance))
}

fn told(row: Option<&Row>) -> String {
    match row {
        None => "–".to_owned(),
        Some(row) if row.converged() => {
            let seconds = in_seconds(row.numbers.seconds);
            format!("{}, {seconds}", row.numbers.iterations)
        }
        Some(row) => row.outcome.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;

    #[test]
    fn every_experiment_has_a_run_of_ours_that_comes_closest() {
        let records = reader(EXPERIMENTS.as_bytes()).into_records();
        let records: Vec<StringRecord> = records.collect::<Result<_, _>>().unwrap();
        let run = |record: &StringRecord| samples::row(&record[4], &record[5], &record[6], 2.0);
        let table = table(&samples::results(records.iter().map(run).collect()));
        assert_eq!(table.rows().len(), 11);
        for line in table.rows() {
            assert!(line[3].ends_with(", 123 unknowns"), "{line:?}");
            assert_eq!(line[4], "0, 2.00 s");
        }
        assert_eq!(table.rows()[2][2], "21, 0.99 s");
    }
}
