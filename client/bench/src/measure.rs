//! One run: a fresh process of this program, so that its seconds are those of a
//! cold start and its peak memory is its own.

use std::path::Path;
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use tokio::process::Command;

use crate::family::Quantity;
use crate::outcome::{Outcome, outcome, without_result, word};
use crate::plan::Case;

impl std::fmt::Display for Outcome {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(&self.spoken())?;
        let detail = self.detail();
        match detail.strip_prefix("not_converged, ").unwrap_or(detail) {
            "" | "not_converged" => Ok(()),
            detail => write!(out, ": {detail}"),
        }
    }
}

/// Stands in keys of methods for the name of the obstacle of a family.
const OBSTACLE: &str = "OBSTACLE";

/// Phases of a solve, as result lines name them.
pub(crate) const PHASES: [&str; 6] = [
    "prepare",
    "assemble",
    "factorise",
    "krylov",
    "contact",
    "stability",
];

/// What one process reported.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Numbers {
    /// `seconds.total` without the norms of the error; of a run without a result,
    /// its wall time.
    pub(crate) seconds: f64,
    /// Seconds that the norms of the error against an exact field took.
    pub(crate) error_norm_seconds: f64,
    /// Seconds of [`PHASES`].
    pub(crate) phases: [f64; PHASES.len()],
    /// Displacement, pressure and contact unknowns.
    pub(crate) unknowns: [i64; 3],
    /// Those that have a result, and the quadratic programs of all of them.
    pub(crate) increments: i64,
    pub(crate) programs: i64,
    pub(crate) iterations: i64,
    pub(crate) applications: i64,
    pub(crate) peak_memory_bytes: Option<i64>,
    pub(crate) instruction_set: String,
    /// By [`Quantity`], as [`Quantity::read`] gives them.
    pub(crate) values: Vec<(Quantity, f64)>,
    /// Relative error that the solver estimates, energy norm.
    pub(crate) estimate: Option<f64>,
    /// Relative error that it estimates for the force of the obstacle.
    pub(crate) force_estimate: Option<f64>,
}

/// A finished run.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub(crate) outcome: Outcome,
    pub(crate) numbers: Numbers,
}

/// Runs a case; a process that takes longer than `limit` is stopped.
pub(crate) async fn measure(
    program: &Path,
    case: &Case,
    files: (&Path, &Path),
    limit: Duration,
) -> Run {
    let started = Instant::now();
    let mut command = command(program, case, files);
    let ended = tokio::time::timeout(limit, command.output()).await;
    let seconds = started.elapsed().as_secs_f64();
    let failed = |outcome| Run {
        outcome,
        numbers: Numbers {
            seconds,
            ..Numbers::default()
        },
    };
    match ended {
        Err(_) => failed(Outcome::TimeLimit),
        Ok(Err(error)) => failed(Outcome::Crashed(error.to_string())),
        Ok(Ok(output)) => read(&output, case).unwrap_or_else(|| failed(without_result(&output))),
    }
}

fn command(program: &Path, case: &Case, (scene, mesh): (&Path, &Path)) -> Command {
    let mut command = Command::new(program);
    command.args(["solve", "--json", "--quiet"]).arg(scene);
    let keys = [
        format!("mesh={}", mesh.display()),
        format!("solver.tolerance={:e}", case.tolerance),
    ];
    let settings = case.family.settings.iter().map(|key| (*key).to_owned());
    for key in keys
        .into_iter()
        .chain(settings)
        .chain(case.method.overrides())
    {
        let key = key.replace(OBSTACLE, &case.family.obstacle());
        command.arg("--set").arg(key);
    }
    command.stdin(Stdio::null()).kill_on_drop(true);
    command
}

/// The run of an output with result lines.
fn read(output: &Output, case: &Case) -> Option<Run> {
    let text = String::from_utf8_lossy(&output.stdout);
    let lines = text.lines().rev();
    let lines = lines.filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let lines: Vec<Value> = lines.collect();
    let last = |event: &str| {
        let mut lines = lines.iter();
        lines.find(|line| line.get("event").is_some_and(|name| name == event))
    };
    let (step, summary) = (last("step")?, last("summary")?);
    let numbers = numbers(step, summary, case);
    Some(Run {
        outcome: outcome(step),
        numbers: Numbers {
            seconds: numbers.seconds + rounds(&lines),
            ..numbers
        },
    })
}

/// Seconds of the meshes on the way to the last one.
fn rounds(lines: &[Value]) -> f64 {
    let rounds = lines.iter().filter(|line| word(line, "event") == "round");
    let seconds = rounds.filter_map(|line| line.get("seconds")?.as_f64());
    seconds.sum()
}

fn count(line: &Value, path: &str) -> i64 {
    let value = line.pointer(path).and_then(Value::as_i64);
    value.unwrap_or_default()
}

fn seconds(summary: &Value, phase: &str) -> f64 {
    let path = format!("/totals/seconds/{phase}");
    let value = summary.pointer(&path).and_then(Value::as_f64);
    value.unwrap_or_default()
}

fn numbers(step: &Value, summary: &Value, case: &Case) -> Numbers {
    let blocks = ["displacement", "pressure", "contact"];
    let family = case.family;
    let value = |quantity: &Quantity| Some((*quantity, quantity.read(step, family.whole_body)?));
    let error_norm_seconds = seconds(summary, "error_norms");
    Numbers {
        seconds: seconds(summary, "total") - error_norm_seconds,
        error_norm_seconds,
        phases: PHASES.map(|phase| seconds(summary, phase)),
        unknowns: blocks.map(|block| count(step, &format!("/unknowns/{block}"))),
        increments: count(summary, "/totals/increments"),
        programs: count(summary, "/totals/sqp_iterations"),
        iterations: count(summary, "/totals/krylov_iterations"),
        applications: count(summary, "/totals/preconditioner_applications"),
        peak_memory_bytes: summary.get("peak_memory_bytes").and_then(Value::as_i64),
        instruction_set: word(step, "instruction_set").to_owned(),
        values: family.quantities.iter().filter_map(value).collect(),
        estimate: step.get("error_estimate").and_then(Value::as_f64),
        force_estimate: force_estimate(step),
    }
}

/// The estimated error of the first obstacle's force over that force.
fn force_estimate(step: &Value) -> Option<f64> {
    let obstacle = step.get("obstacles")?.as_object()?.values().next()?;
    let force = obstacle.get("force")?.as_array()?;
    let square: f64 = force.iter().filter_map(Value::as_f64).map(|x| x * x).sum();
    Some(obstacle.get("force_error")?.as_f64()? / square.sqrt())
}

#[cfg(test)]
mod tests {
    use std::os::unix::process::ExitStatusExt as _;

    use super::*;
    use crate::families::find;
    use crate::plan::Place;

    fn case() -> Case {
        Case {
            family: find("hertz-plane").unwrap(),
            level: "l1".parse().unwrap(),
            method: "auto".parse().unwrap(),
            tolerance: 1e-8,
            place: Place::Chapter,
            repeats: 1,
            run_limit: Duration::from_secs(1),
        }
    }

    fn output(code: i32, stdout: &str, stderr: &str) -> Output {
        Output {
            status: std::process::ExitStatus::from_raw(code << 8),
            stdout: stdout.into(),
            stderr: stderr.into(),
        }
    }

    #[test]
    fn result_lines_become_numbers() {
        let lines = r#"{"event":"plan"}
{"event":"step","termination":"not_converged","cause":"stagnation","strain_energy":0.5,"unknowns":{"displacement":30,"pressure":4,"contact":2},"error_estimate":0.01,"obstacles":{"floor":{"force":[0,0,2.0],"force_error":0.1,"max_pressure":0.6}},"instruction_set":"avx2"}
{"event":"summary","peak_memory_bytes":1000,"totals":{"increments":2,"sqp_iterations":5,"krylov_iterations":7,"preconditioner_applications":8,"seconds":{"krylov":0.25,"error_norms":0.5,"total":1.0}}}
"#;
        let run = read(&output(3, lines, ""), &case()).unwrap();
        assert_eq!(
            run.outcome,
            Outcome::NotConverged("not_converged, stagnation".into())
        );
        assert_eq!(run.numbers.unknowns, [30, 4, 2]);
        assert_eq!((run.numbers.seconds, run.numbers.phases[3]), (0.5, 0.25));
        assert_eq!((run.numbers.increments, run.numbers.programs), (2, 5));
        assert!(run.numbers.values.contains(&(Quantity::Force, 8.0)));
        assert_eq!(run.numbers.peak_memory_bytes, Some(1000));
        assert_eq!(run.numbers.estimate, Some(0.01));
        assert_eq!(run.numbers.force_estimate, Some(0.05));
        assert_eq!(case().family.obstacle(), "floor");
    }

    #[test]
    fn meshes_on_the_way_count_in_the_seconds() {
        let lines = r#"{"event":"round","seconds":0.5}
{"event":"round","seconds":1.5}
{"event":"step","termination":"converged"}
{"event":"summary","totals":{"seconds":{"total":1.0}}}
"#;
        let run = read(&output(0, lines, ""), &case()).unwrap();
        assert!((run.numbers.seconds - 3.0).abs() < 1e-12);
    }

    #[test]
    fn processes_without_a_result_say_why() {
        let refused = output(4, "", "error: solver.p1_solver: not supported yet\n");
        assert!(read(&refused, &case()).is_none());
        assert_eq!(
            without_result(&refused),
            Outcome::Refused("solver.p1_solver: not supported yet".into())
        );
        assert!(without_result(&refused).refuses_the_method());
        assert!(!Outcome::Refused("solver.tolerance: 7".into()).refuses_the_method());
        let crashed = output(101, "", "thread panicked\nat\n");
        assert_eq!(
            without_result(&crashed),
            Outcome::Crashed("exit code 101: thread panicked".into())
        );
    }
}
