//! Measured curves of a scene, from a table: a row a time, a column a goal.
//!
//! Columns `time` (steps that are done, 0.5 in the middle of the first) and goals by their names, such as
//! `force.lid.y`; other columns are left out, and so are empty places. Commas, semicolons or tabs between them; lines
//! that begin with `#` are left out. Cost: one pass.

use csv::{ReaderBuilder, StringRecord, Trim};
use thiserror::Error;

use super::test_curves::delimiter;

/// Most rows.
const MOST: usize = 100_000;
/// Largest value at time 0 over the largest of a curve that is noise, without unit; chosen.
const NOISE: f64 = 0.01;
/// How columns of goals begin.
const KINDS: [&str; 6] = [
    "force.",
    "moment.",
    "reaction.",
    "displacement.",
    "max_pressure.",
    "strain_energy",
];

/// A measured value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    pub(crate) time: f64,
    /// Number of its goal.
    pub(crate) goal: usize,
    pub(crate) value: f64,
}

/// Measured values of goals.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct GoalCurves {
    pub(crate) goals: Vec<String>,
    /// In the order of the rows.
    pub(crate) points: Vec<Point>,
}

/// Why a table has no curves of a scene.
#[derive(Debug, Error)]
pub(crate) enum GoalCurveError {
    #[error("no column \"time\" in the first row: columns are time and goals, such as force.lid.y")]
    Time,
    #[error("no column of a goal in the first row, such as force.lid.y or displacement.tip.x")]
    Goals,
    #[error("line {line}: \"{found}\" is no number, which column {column} holds")]
    Number {
        line: u64,
        column: String,
        found: String,
    },
    #[error("line {line}: time {time} is not between zero and {most}, the number of steps")]
    Late { line: u64, time: f64, most: f64 },
    #[error(
        "line {line}: {column} is {value} at time 0, where nothing acts yet and every goal is zero: take \
         off the whole column what it begins with"
    )]
    Offset {
        line: u64,
        column: String,
        value: f64,
    },
    #[error("there are no values below the first row")]
    Empty,
    #[error("more than {MOST} rows")]
    TooMany,
    #[error(transparent)]
    Table(#[from] csv::Error),
}

/// Whether the first row is that of test curves of a material.
pub(crate) fn has_tests(bytes: &[u8]) -> bool {
    let header = reader(bytes).headers().cloned();
    header.is_ok_and(|header| header.iter().any(|name| plain(name) == "test"))
}

fn plain(name: &str) -> String {
    name.trim_start_matches('\u{feff}').to_ascii_lowercase()
}

fn reader(bytes: &[u8]) -> csv::Reader<&[u8]> {
    ReaderBuilder::new()
        .delimiter(delimiter(bytes))
        .comment(Some(b'#'))
        .trim(Trim::All)
        .from_reader(bytes)
}

/// The curves of a table, of a scene with that many `steps`. Rows at time 0 say nothing of constants: they
/// are left out where they are zero.
///
/// # Errors
/// [`GoalCurveError`], the first one found.
pub(crate) fn read(bytes: &[u8], steps: usize) -> Result<GoalCurves, GoalCurveError> {
    let mut reader = reader(bytes);
    let header = reader.headers()?.clone();
    let time = header.iter().position(|name| plain(name) == "time");
    let time = time.ok_or(GoalCurveError::Time)?;
    let is_goal = |name: &str| KINDS.iter().any(|kind| name.starts_with(kind));
    let columns = header.iter().enumerate().filter(|(_, name)| is_goal(name));
    let columns: Vec<(usize, &str)> = columns.collect();
    if columns.is_empty() {
        return Err(GoalCurveError::Goals);
    }
    let mut curves = GoalCurves {
        goals: columns.iter().map(|(_, name)| (*name).to_owned()).collect(),
        points: Vec::new(),
    };
    let mut begun = Vec::new();
    for (row, record) in reader.records().enumerate() {
        if row == MOST {
            return Err(GoalCurveError::TooMany);
        }
        let record = record?;
        let at = moment(&record, time, steps)?;
        for (goal, (column, name)) in columns.iter().enumerate() {
            if record.get(*column).is_some_and(|text| !text.is_empty()) {
                let value = number(&record, (*column, name))?;
                if at > 0.0 {
                    curves.points.push(Point {
                        time: at,
                        goal,
                        value,
                    });
                } else {
                    begun.push((goal, line(&record), value));
                }
            }
        }
    }
    if curves.points.is_empty() {
        return Err(GoalCurveError::Empty);
    }
    curves.check_begun(&begun)?;
    Ok(curves)
}

impl GoalCurves {
    /// Refuses what is not at rest at time 0: by goal, line and value.
    fn check_begun(&self, begun: &[(usize, u64, f64)]) -> Result<(), GoalCurveError> {
        let largest = |goal: usize| {
            let own = self.points.iter().filter(|point| point.goal == goal);
            own.map(|point| point.value.abs()).fold(0.0, f64::max)
        };
        let offset = |&&(goal, _, value): &&(usize, u64, f64)| value.abs() > NOISE * largest(goal);
        let Some(&(goal, line, value)) = begun.iter().find(offset) else {
            return Ok(());
        };
        let column = self.goals.get(goal).cloned().unwrap_or_default();
        Err(GoalCurveError::Offset {
            line,
            column,
            value,
        })
    }
}

fn moment(record: &StringRecord, column: usize, steps: usize) -> Result<f64, GoalCurveError> {
    let time = number(record, (column, "time"))?;
    let most = steps as f64;
    if (0.0..=most).contains(&time) {
        return Ok(time);
    }
    let line = line(record);
    Err(GoalCurveError::Late { line, time, most })
}

fn line(record: &StringRecord) -> u64 {
    record.position().map_or(0, csv::Position::line)
}

fn number(record: &StringRecord, (column, name): (usize, &str)) -> Result<f64, GoalCurveError> {
    let text = record.get(column).unwrap_or_default();
    let value = text.parse().ok().filter(|value: &f64| value.is_finite());
    value.ok_or_else(|| GoalCurveError::Number {
        line: line(record),
        column: name.to_owned(),
        found: text.chars().take(40).collect(),
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn goals_are_columns_and_empty_places_are_left_out() {
        let table = "time;note;force.lid.y;displacement.tip.x\n0.5;a;-1;\n1;b;-2.5;0.1\n";
        let found = read(table.as_bytes(), 1).unwrap();
        assert_eq!(found.goals, ["force.lid.y", "displacement.tip.x"]);
        let expected = [(0.5, 0, -1.0), (1.0, 0, -2.5), (1.0, 1, 0.1)];
        let expected = expected.map(|(time, goal, value)| Point { time, goal, value });
        assert_eq!(found.points, expected);
        assert!(has_tests(b"stress,Test,stretch\n") && !has_tests(table.as_bytes()));
    }

    #[test]
    fn a_first_row_at_time_zero_is_that_of_the_body_at_rest() {
        let table = |value: &str| format!("time,force.lid.y\n0,{value}\n1,-2.5\n");
        // Noise of the instrument.
        let found = read(table("0.02").as_bytes(), 1).unwrap();
        let expected = Point {
            time: 1.0,
            goal: 0,
            value: -2.5,
        };
        assert_eq!(found.points, [expected]);
        let fault = read(table("0.1").as_bytes(), 1).unwrap_err().to_string();
        assert!(fault.starts_with("line 2: force.lid.y is 0.1"), "{fault}");
    }

    #[test]
    fn faults_are_told_with_their_line() {
        let told = |table: &str| read(table.as_bytes(), 2).unwrap_err().to_string();
        assert!(told("t,force.a.x\n").contains("no column \"time\""));
        assert!(told("time,load\n1,2\n").contains("no column of a goal"));
        assert!(told("time,force.a.x\n1,2\n3,4\n").starts_with("line 3: time 3"));
        assert!(told("time,force.a.x\n1,two\n").contains("\"two\" is no number"));
        assert!(told("time,force.a.x\n1,\n").contains("no values"));
    }

    proptest! {
        #[test]
        fn no_table_is_too_odd(bytes in proptest::collection::vec(any::<u8>(), 0..200), steps in 0..4_usize) {
            let _outcome = read(&bytes, steps);
            let _is_tests = has_tests(&bytes);
        }
    }
}
