//! The seed's own experiments (M. Fortin and A. El Maliki, *A hierarchical
//! preconditioner for Stokes and connected problems*, slides of 23 October
//! 2007), and the runs of this report that come closest. Its tolerance and its
//! machine are not told: its counts compare, its seconds do not.

use super::answer::in_seconds;
use super::figures::Results;
use super::row::Row;

/// One line of its tables.
struct Experiment {
    problem: &'static str,
    method: &'static str,
    steps: u32,
    seconds: f64,
    /// Family, level number, keys of ours.
    ours: (&'static str, u32, &'static str),
}

const STATIONARY: &str = "saddle=stationary,displacement_preconditioner=hierarchical-ssor";
const HIERARCHICAL: &str = "displacement_preconditioner=hierarchical-ssor";
const ARROW: &str = "saddle=arrow-hurwicz,displacement_preconditioner=hierarchical-ssor";

const fn experiment(
    problem: &'static str,
    method: &'static str,
    steps: u32,
    seconds: f64,
    ours: (&'static str, u32, &'static str),
) -> Experiment {
    Experiment {
        problem,
        method,
        steps,
        seconds,
        ours,
    }
}

const EXPERIMENTS: &[Experiment] = &[
    experiment(
        "elasticity",
        "block SSOR alone",
        27,
        42.0,
        ("cube-elastic", 16, STATIONARY),
    ),
    experiment(
        "elasticity",
        "block SSOR in CG",
        14,
        22.0,
        ("cube-elastic", 16, HIERARCHICAL),
    ),
    experiment(
        "cylinder, 1959 triangles",
        "Arrow-Hurwicz + GCR",
        21,
        0.99,
        ("stokes-cylinder", 1, ARROW),
    ),
    experiment(
        "cylinder, 7836 triangles",
        "Arrow-Hurwicz + GCR",
        20,
        4.1,
        ("stokes-cylinder", 2, ARROW),
    ),
    experiment(
        "cylinder, 7836 triangles",
        "Uzawa",
        18,
        7.9,
        ("stokes-cylinder", 2, "saddle=uzawa-cg"),
    ),
    experiment(
        "obstacle, 9067 tetrahedra",
        "Uzawa, r = 0",
        32,
        273.0,
        ("stokes-obstacle", 1, "saddle=uzawa-cg"),
    ),
    experiment(
        "obstacle, 9067 tetrahedra",
        "Uzawa, r = 5",
        21,
        243.0,
        ("stokes-obstacle", 1, "saddle=uzawa-cg,penalty=5"),
    ),
    experiment(
        "obstacle, 9067 tetrahedra",
        "Arrow-Hurwicz + GCR, r = 0",
        35,
        25.95,
        ("stokes-obstacle", 1, ARROW),
    ),
    experiment(
        "obstacle, 9067 tetrahedra",
        "Arrow-Hurwicz + GCR, r = 5",
        25,
        18.41,
        (
            "stokes-obstacle",
            1,
            "saddle=arrow-hurwicz,displacement_preconditioner=hierarchical-ssor,penalty=5",
        ),
    ),
    experiment(
        "obstacle, 72 536 tetrahedra",
        "Arrow-Hurwicz + GCR, r = 0",
        38,
        276.6,
        ("stokes-obstacle", 2, ARROW),
    ),
    experiment(
        "obstacle, 72 536 tetrahedra",
        "Arrow-Hurwicz + GCR, r = 5",
        28,
        204.6,
        (
            "stokes-obstacle",
            2,
            "saddle=arrow-hurwicz,displacement_preconditioner=hierarchical-ssor,penalty=5",
        ),
    ),
];

/// A line of the table: what the seed measured, the same method here, and the
/// default here.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Line {
    pub(crate) cells: [String; 6],
}

/// Titles of [`lines`].
pub(crate) const TITLES: [&str; 6] = [
    "problem of the seed",
    "its method",
    "its steps, seconds (2007)",
    "mesh here",
    "its method here: steps, seconds",
    "default here: steps, seconds",
];

/// All lines.
pub(crate) fn lines(results: &Results) -> Vec<Line> {
    EXPERIMENTS.iter().map(|one| line(results, one)).collect()
}

fn line(results: &Results, experiment: &Experiment) -> Line {
    let (family, level, keys) = experiment.ours;
    let same = row(results, family, level, keys);
    let default = row(results, family, level, "auto");
    let mesh = default.or(same).map_or_else(
        || "not measured".to_owned(),
        |row| {
            format!(
                "{family} {}, {:.0} unknowns",
                row.case.level,
                row.unknowns()
            )
        },
    );
    Line {
        cells: [
            experiment.problem.to_owned(),
            experiment.method.to_owned(),
            format!("{}, {} s", experiment.steps, experiment.seconds),
            mesh,
            told(same),
            told(default),
        ],
    }
}

/// The tightest row of a case.
fn row<'a>(results: &'a Results, family: &str, level: u32, keys: &str) -> Option<&'a Row> {
    let method = keys.parse().ok()?;
    let rows = results.rows.iter().filter(|row| {
        let case = &row.case;
        case.family.name == family && case.level.number == level && case.method == method
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
