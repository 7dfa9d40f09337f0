//! Rows and results that tests make up.

use std::time::Duration;

use crate::families::find;
use crate::machine::Machine;
use crate::measure::Numbers;
use crate::outcome::Outcome;
use crate::peers::Peers;
use crate::plan::{Case, Place};
use crate::reference::References;
use crate::results::Results;
use crate::row::Row;

/// A converged run of `scene level` with these keys: 123 unknowns, tolerance 1e-8.
pub(crate) fn row(scene: &str, level: &str, keys: &str, seconds: f64) -> Row {
    let numbers = Numbers {
        seconds,
        unknowns: [100, 20, 3],
        ..Numbers::default()
    };
    Row {
        case: Case {
            family: find(scene).unwrap(),
            level: level.parse().unwrap(),
            method: keys.parse().unwrap(),
            tolerance: 1e-8,
            place: Place::Study,
            repeats: 1,
            run_limit: Duration::from_secs(1),
        },
        outcome: Outcome::Converged,
        numbers,
        repeats: 1,
        least_seconds: seconds,
        most_seconds: seconds,
        errors: Vec::new(),
    }
}

/// Rows on a machine of two cores, without other solvers.
pub(crate) fn results(rows: Vec<Row>) -> Results {
    Results {
        rows,
        recorded: Vec::new(),
        findings: Vec::new(),
        peers: Peers::default(),
        references: References::shipped().unwrap(),
        machine: Machine {
            processor: "P".into(),
            cores: 2,
            build: "b".into(),
        },
    }
}
