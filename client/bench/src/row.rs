//! The table: one row a case, with its errors.

use crate::family::Quantity;
use crate::machine::Machine;
use crate::measure::{Numbers, PHASES, Run};
use crate::outcome::Outcome;
use crate::plan::Case;
use crate::reference::References;
use crate::rounds::Measured;

/// A measured case.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) case: Case,
    pub(crate) outcome: Outcome,
    /// Of the run of median seconds.
    pub(crate) numbers: Numbers,
    pub(crate) repeats: usize,
    /// Of the fastest run.
    pub(crate) least_seconds: f64,
    /// Of the slowest run.
    pub(crate) most_seconds: f64,
    /// Relative.
    pub(crate) errors: Vec<(Quantity, f64)>,
}

impl Row {
    /// The row of a case; none when it did not run.
    pub(crate) fn new(measured: Measured, references: &References) -> Option<Self> {
        let Measured { case, mut runs, .. } = measured;
        let repeats = runs.len();
        let seconds = |run: &Run| run.numbers.seconds;
        runs.sort_by(|a, b| seconds(a).total_cmp(&seconds(b)));
        let least_seconds = seconds(runs.first()?);
        let most_seconds = seconds(runs.last()?);
        // A failure is what a case is told by, however often it went well.
        let failure = runs
            .iter()
            .position(|run| run.outcome != Outcome::Converged);
        let run = runs.swap_remove(failure.unwrap_or((repeats - 1) / 2));
        let errors = run.numbers.values.iter().filter_map(|&(quantity, value)| {
            let error = references.relative(case.family.name, quantity, value)?;
            Some((quantity, error))
        });
        Some(Self {
            errors: errors.collect(),
            outcome: run.outcome,
            numbers: run.numbers,
            repeats,
            least_seconds,
            most_seconds,
            case,
        })
    }

    /// Its relative error.
    pub(crate) fn error(&self, quantity: Quantity) -> Option<f64> {
        let mut errors = self.errors.iter();
        errors
            .find(|error| error.0 == quantity)
            .map(|error| error.1)
    }

    /// All unknowns.
    pub(crate) fn unknowns(&self) -> f64 {
        self.numbers.unknowns.iter().sum::<i64>() as f64
    }

    /// Peak memory of the process, MB.
    pub(crate) fn peak_memory_mb(&self) -> Option<f64> {
        let bytes = self.numbers.peak_memory_bytes?;
        Some(bytes as f64 * 1e-6)
    }

    /// Whether it met its tolerance.
    pub(crate) fn converged(&self) -> bool {
        self.outcome == Outcome::Converged
    }
}

/// Quantities whose value is in the table beside its error.
const VALUES: [Quantity; 5] = [
    Quantity::StrainEnergy,
    Quantity::Force,
    Quantity::TangentialForce,
    Quantity::ContactPressure,
    Quantity::ContactRadius,
];

/// Titles of [`fields`].
fn titles() -> Vec<String> {
    let mut titles: Vec<String> = [
        "scene",
        "level",
        "method",
        "tolerance",
        "outcome",
        "detail",
        "unknowns_displacement",
        "unknowns_pressure",
        "unknowns_contact",
        "increments",
        "programs",
        "krylov_iterations",
        "applications",
        "repeats",
        "seconds_median",
        "seconds_least",
        "seconds_most",
        "seconds_error_norms",
    ]
    .map(str::to_owned)
    .to_vec();
    titles.extend(PHASES.map(|phase| format!("seconds_{phase}")));
    titles.push("peak_memory_bytes".to_owned());
    titles.extend(Quantity::ALL.map(|quantity| format!("error_{}", quantity.name())));
    titles.extend(VALUES.map(|quantity| format!("value_{}", quantity.name())));
    titles.extend(["estimate_energy_norm", "estimate_force"].map(str::to_owned));
    titles.extend(["instruction_set", "threads", "processor", "build"].map(str::to_owned));
    titles
}

fn fields(row: &Row, machine: &Machine) -> Vec<String> {
    let numbers = &row.numbers;
    let mut fields = vec![
        row.case.family.name.to_owned(),
        row.case.level.to_string(),
        row.case.method.to_string(),
        format!("{:e}", row.case.tolerance),
        row.outcome.word().to_owned(),
        row.outcome.detail().to_owned(),
    ];
    fields.extend(numbers.unknowns.map(|count| count.to_string()));
    let counts = [
        numbers.increments,
        numbers.programs,
        numbers.iterations,
        numbers.applications,
    ];
    fields.extend(counts.map(|count| count.to_string()));
    fields.push(row.repeats.to_string());
    fields.extend(
        [numbers.seconds, row.least_seconds, row.most_seconds]
            .map(|seconds| format!("{seconds:.6}")),
    );
    fields.push(format!("{:.6}", numbers.error_norm_seconds));
    fields.extend(numbers.phases.map(|seconds| format!("{seconds:.6}")));
    fields.push(
        numbers
            .peak_memory_bytes
            .map_or_else(String::new, |bytes| bytes.to_string()),
    );
    let error = |quantity| {
        row.error(quantity)
            .map_or_else(String::new, |error| format!("{error:.6e}"))
    };
    fields.extend(Quantity::ALL.map(error));
    let value = |quantity| {
        let mut values = numbers.values.iter();
        let value = values.find(|value| value.0 == quantity);
        value.map_or_else(String::new, |value| format!("{:.12e}", value.1))
    };
    fields.extend(VALUES.map(value));
    let estimates = [numbers.estimate, numbers.force_estimate];
    fields.extend(estimates.map(|value| value.map_or_else(String::new, |v| format!("{v:.6e}"))));
    fields.push(numbers.instruction_set.clone());
    fields.push(machine.cores.to_string());
    fields.extend([machine.processor.clone(), machine.build.clone()]);
    fields
}

/// The rows as CSV.
///
/// # Errors
/// What the writer says; writing to memory does not fail.
pub(crate) fn csv(rows: &[Row], machine: &Machine) -> Result<Vec<u8>, String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let fail = |error: csv::Error| error.to_string();
    writer.write_record(titles()).map_err(fail)?;
    for row in rows {
        writer.write_record(fields(row, machine)).map_err(fail)?;
    }
    writer.into_inner().map_err(|error| error.to_string())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::families::find;
    use crate::plan::Place;

    fn run(seconds: f64, outcome: Outcome, value: f64) -> Run {
        let numbers = Numbers {
            seconds,
            unknowns: [100, 20, 3],
            values: vec![(Quantity::Force, value)],
            ..Numbers::default()
        };
        Run { outcome, numbers }
    }

    pub(crate) fn row(runs: Vec<Run>) -> Option<Row> {
        let case = Case {
            family: find("hertz-plane").unwrap(),
            level: "l2".parse().unwrap(),
            method: "p1_solver=cholesky,saddle=gcr".parse().unwrap(),
            tolerance: 1e-8,
            place: Place::Chapter,
            repeats: 3,
            run_limit: std::time::Duration::from_secs(1),
        };
        let measured = Measured {
            case,
            runs,
            left_out: None,
        };
        Row::new(measured, &References::shipped().unwrap())
    }

    #[test]
    fn a_case_is_its_run_of_median_seconds() {
        let runs = [3.0, 1.0, 2.0].map(|seconds| run(seconds, Outcome::Converged, 0.07));
        let row = row(runs.to_vec()).unwrap();
        assert_eq!(
            (row.least_seconds, row.numbers.seconds, row.most_seconds),
            (1.0, 2.0, 3.0)
        );
        assert!(row.error(Quantity::Force).unwrap() < 0.03);
        assert_eq!(row.error(Quantity::StrainEnergy), None);
        assert!((row.unknowns() - 123.0).abs() < 1e-9);
    }

    #[test]
    fn one_failure_makes_a_case_a_failure() {
        let failed = run(9.0, Outcome::NotConverged("stagnation".into()), 0.07);
        let row = row(vec![run(1.0, Outcome::Converged, 0.07), failed]).unwrap();
        assert!(!row.converged());
        assert_eq!((row.numbers.seconds, row.repeats), (9.0, 2));
    }

    #[test]
    fn cases_that_did_not_run_have_no_row() {
        assert!(row(Vec::new()).is_none());
    }

    #[test]
    fn every_row_has_a_field_for_every_title() {
        let row = row(vec![run(1.0, Outcome::Crashed("a, \"b\"".into()), 0.07)]).unwrap();
        let machine = Machine {
            processor: "P".into(),
            cores: 2,
            build: "b".into(),
        };
        let text = csv(&[row], &machine).unwrap();
        let mut reader = csv::Reader::from_reader(text.as_slice());
        let titles = reader.headers().unwrap().clone();
        let record = reader.records().next().unwrap().unwrap();
        let field = |title: &str| {
            let column = titles.iter().position(|name| name == title).unwrap();
            record.get(column).unwrap().to_owned()
        };
        assert_eq!(titles.len(), record.len());
        assert_eq!(field("detail"), "a, \"b\"");
        assert_eq!(field("method"), "p1_solver=cholesky saddle=gcr");
        assert_eq!(field("unknowns_contact"), "3");
        assert_eq!(field("error_pressure_l2"), "");
        assert_eq!(field("build"), "b");
    }
}
