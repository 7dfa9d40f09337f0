//! Runs of methods that the program no longer has, as `bench.csv` had them when it did.
//!
//! Columns, by name, are those of [`crate::row`]; lines that begin with `#` say how they were
//! recorded. The default method is among them, so that seconds compare on one machine.

use std::time::Duration;

use csv::StringRecord;

use crate::commented::reader;
use crate::families;
use crate::family::Quantity;
use crate::measure::Numbers;
use crate::outcome::Outcome;
use crate::plan::{Case, Place};
use crate::row::Row;

/// MINI and Bernardi-Raugel beside Taylor-Hood.
const ELEMENTS: &str = include_str!("elements.csv");

/// The recorded runs.
///
/// # Errors
/// What is wrong with a line, which a test excludes.
pub(crate) fn rows() -> Result<Vec<Row>, String> {
    let mut reader = reader(ELEMENTS.as_bytes());
    let header = reader.headers().map_err(|error| error.to_string())?.clone();
    let records = reader.into_records();
    let rows = records.map(|record| {
        let record = record.map_err(|error| error.to_string())?;
        row(&Line(&header, &record))
    });
    rows.collect()
}

/// One line with the names of its columns.
struct Line<'a>(&'a StringRecord, &'a StringRecord);

impl<'a> Line<'a> {
    fn text(&self, name: &str) -> Result<&'a str, String> {
        let column = self.0.iter().position(|title| title == name);
        let text = column.and_then(|column| self.1.get(column));
        text.ok_or_else(|| format!("{name} is missing"))
    }

    /// None of an empty field.
    fn number(&self, name: &str) -> Result<Option<f64>, String> {
        match self.text(name)? {
            "" => Ok(None),
            text => text
                .parse()
                .map(Some)
                .map_err(|_| format!("{name}: {text}")),
        }
    }

    fn required(&self, name: &str) -> Result<f64, String> {
        self.number(name)?
            .ok_or_else(|| format!("{name} is missing"))
    }
}

fn row(line: &Line<'_>) -> Result<Row, String> {
    let repeats = line.required("repeats")? as usize;
    let case = Case {
        family: families::find(line.text("scene")?)?,
        level: line.text("level")?.parse()?,
        method: line.text("method")?.replace(' ', ",").parse()?,
        tolerance: line.required("tolerance")?,
        place: Place::Study,
        repeats,
        run_limit: Duration::ZERO,
    };
    let mut errors = Vec::new();
    for quantity in Quantity::ALL {
        let error = line.number(&format!("error_{}", quantity.name()))?;
        errors.extend(error.map(|error| (quantity, error)));
    }
    Ok(Row {
        case,
        outcome: match line.text("outcome")? {
            "converged" => Outcome::Converged,
            "time_limit" => Outcome::TimeLimit,
            "refused" => Outcome::Refused(line.text("detail")?.to_owned()),
            _ => Outcome::NotConverged(line.text("detail")?.to_owned()),
        },
        numbers: numbers(line)?,
        repeats,
        least_seconds: line.required("seconds_least")?,
        most_seconds: line.required("seconds_most")?,
        errors,
    })
}

fn numbers(line: &Line<'_>) -> Result<Numbers, String> {
    let count = |name: &str| line.required(name).map(|count| count as i64);
    Ok(Numbers {
        seconds: line.required("seconds_median")?,
        unknowns: [
            count("unknowns_displacement")?,
            count("unknowns_pressure")?,
            count("unknowns_contact")?,
        ],
        iterations: count("krylov_iterations")?,
        applications: count("applications")?,
        ..Numbers::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_recorded_run_converged_with_an_error_and_its_seconds() {
        for row in rows().unwrap() {
            assert!(row.converged(), "{}", row.case.name());
            assert!(!row.errors.is_empty() && row.numbers.seconds > 0.0);
        }
    }
}
