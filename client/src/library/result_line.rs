//! Result lines: one JSON object a line, the same content as the stream.
//!
//! `event` is `plan`, `round`, `iteration`, `step` or `summary`; `session` and `cancel`
//! answer single commands. Plans and reports are written as their messages are,
//! key by key, so a new number of a report needs no word here. The form is kept in
//! `client/result-lines.schema.json`; numbers are printed so that reading them
//! gives the same double. What is not finite becomes null.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Value, json};
use signorini_proto::{v1, words};

/// A line of one event: its content's keys follow.
#[derive(Serialize)]
struct Line<'a, T> {
    event: &'static str,
    #[serde(flatten)]
    content: &'a T,
}

/// What an iteration's line tells beside its report.
#[derive(Serialize)]
struct Iteration {
    #[serde(flatten)]
    report: v1::IterationReport,
    skipped: i64,
}

fn line<T: Serialize>(event: &'static str, content: &T) -> Value {
    json!(Line { event, content })
}

/// The line of a plan, with what the scene calls its units.
pub fn plan(plan: &v1::Plan, units: Option<&v1::UnitNames>) -> Value {
    let mut line = line("plan", plan);
    if let Some(keys) = line.as_object_mut() {
        let named = units.map(
            |units| json!({"length": units.length, "force": units.force, "stress": units.stress}),
        );
        keys.insert("units".to_owned(), named.unwrap_or_default());
    }
    line
}

/// A mesh of those that were refined until goals were known well enough.
#[derive(Clone, Debug, Serialize)]
pub struct Round {
    /// Its number, from 1.
    pub round: u32,
    /// Cells of the mesh.
    pub cells: u64,
    /// Unknowns, those of contact included.
    pub unknowns: u64,
    /// Wall seconds, preparation included.
    pub seconds: f64,
    /// Wall seconds of its dual solutions.
    pub dual_seconds: f64,
    /// What is known of the goals, by their names.
    pub goals: BTreeMap<String, RoundGoal>,
    /// Of the last mesh the word why there is none after it.
    pub end: Option<String>,
    /// The same as a sentence.
    pub why: Option<String>,
}

impl Round {
    /// Whether the goals are known as well as was asked for.
    pub fn is_reached(&self) -> bool {
        self.end.as_deref() == Some("reached")
    }
}

/// A goal on one mesh.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct RoundGoal {
    /// Its value.
    pub value: f64,
    /// What the error is not above.
    pub bound: f64,
    /// The exact value less this one, estimated.
    pub estimate: f64,
    /// The part of flat facets in the bound.
    pub geometry: f64,
    /// Largest error over the absolute value that was asked for.
    pub tolerance: f64,
}

/// The line of a mesh.
pub fn round(round: &Round) -> Value {
    line("round", round)
}

/// The line of an iteration.
pub fn iteration(statistics: &v1::IterationStatistics) -> Value {
    let iteration = Iteration {
        report: statistics.report.unwrap_or_default(),
        skipped: statistics.skipped_count,
    };
    line("iteration", &iteration)
}

/// The line of an increment's result, the pose of each obstacle among what is said of it.
pub fn step(report: &v1::StepReport) -> Value {
    let mut line = line("step", report);
    let poses = line.as_object_mut().and_then(|keys| keys.remove("poses"));
    let Some(Value::Object(poses)) = poses else {
        return line;
    };
    for (name, pose) in poses {
        let obstacle = line.get_mut("obstacles").and_then(|all| all.get_mut(&name));
        if let Some(keys) = obstacle.and_then(Value::as_object_mut) {
            keys.insert("pose".to_owned(), pose);
        }
    }
    line
}

/// The line of a session that was handed to a server.
pub fn session(name: &str) -> Value {
    json!({"event": "session", "name": name})
}

/// The line of a cancelled step; 0 when none was running, which gives null.
pub fn cancel(session: &str, sequence: i64) -> Value {
    let sequence = (sequence > 0).then_some(sequence);
    json!({"event": "cancel", "name": session, "sequence": sequence})
}

/// Sums over all increments of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Totals {
    increments: i64,
    converged: i64,
    sqp_iterations: i64,
    krylov_iterations: i64,
    preconditioner_applications: i64,
    active_set_changes: i64,
    cut_backs: i64,
    factorisations: i64,
    seconds: v1::Seconds,
    termination: v1::Termination,
    verification: Option<v1::Residuals>,
}

impl Totals {
    /// Adds the result of an increment.
    pub fn add(&mut self, report: &v1::StepReport) {
        self.increments += 1;
        self.converged += i64::from(report.termination() == v1::Termination::Converged);
        self.sqp_iterations += i64::from(report.sqp_iterations);
        self.krylov_iterations += i64::from(report.krylov_iterations);
        self.preconditioner_applications += i64::from(report.preconditioner_applications);
        self.active_set_changes += i64::from(report.active_set_changes);
        self.cut_backs += i64::from(report.cut_backs);
        self.factorisations += i64::from(report.factorisations);
        self.add_seconds(report.seconds.unwrap_or_default());
        self.termination = report.termination();
        self.verification = report.verification;
    }

    fn add_seconds(&mut self, seconds: v1::Seconds) {
        self.seconds.prepare += seconds.prepare;
        self.seconds.assemble += seconds.assemble;
        self.seconds.factorise += seconds.factorise;
        self.seconds.krylov += seconds.krylov;
        self.seconds.contact += seconds.contact;
        self.seconds.stability += seconds.stability;
        self.seconds.error_norms += seconds.error_norms;
        self.seconds.total += seconds.total;
    }

    /// How the last increment ended; unspecified before the first.
    pub fn termination(&self) -> v1::Termination {
        self.termination
    }

    /// The line that ends a run. `peak_memory_bytes` is that of the process,
    /// where the system tells; `warnings` are about the run as a whole.
    pub fn summary(
        &self,
        wall_seconds: f64,
        peak_memory_bytes: Option<u64>,
        warnings: &[String],
    ) -> Value {
        json!({
            "event": "summary",
            "wall_seconds": wall_seconds,
            "peak_memory_bytes": peak_memory_bytes,
            "warnings": warnings,
            "verification": self.verification,
            "termination": (self.increments > 0).then(|| words::termination(self.termination)),
            "totals": {
                "increments": self.increments,
                "converged": self.converged,
                "sqp_iterations": self.sqp_iterations,
                "krylov_iterations": self.krylov_iterations,
                "preconditioner_applications": self.preconditioner_applications,
                "active_set_changes": self.active_set_changes,
                "cut_backs": self.cut_backs,
                "factorisations": self.factorisations,
                "seconds": self.seconds,
            },
        })
    }
}
