//! A trial as a process of this program, and what it came to.

use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::Value;
use tokio::process::Command;

use super::catalogue::{Expected, Trial};
use super::lines::{Known, Lines};
use super::peer::Peer;
use super::verdict::{self, Verdict};
use crate::error::BenchError;
use crate::outcome::{Outcome, outcome, without_result};

/// What a trial came to.
#[derive(Clone, Debug)]
pub(crate) struct Finding {
    pub(crate) trial: Trial,
    pub(crate) outcome: Outcome,
    pub(crate) verdict: Verdict,
    /// What it is compared with.
    pub(crate) known: Option<Known>,
    /// What is compared.
    pub(crate) value: Option<f64>,
    /// Relative, against what is known.
    pub(crate) error: Option<f64>,
    /// Of the displacement preconditioner, all steps.
    pub(crate) applications: i64,
    /// Wall time of the solves, or of the process where there is no result.
    pub(crate) seconds: f64,
    /// Of all results, in their order and without repetition.
    pub(crate) warnings: Vec<String>,
    /// Of the last result.
    pub(crate) stability: String,
    /// Falls to other equilibria.
    pub(crate) falls: usize,
    pub(crate) instruction_set: String,
}

/// Writes scene and mesh of a trial into `folder` and runs `program` on them; `before`
/// are the findings so far.
///
/// # Errors
/// A file that cannot be written, or a row that cannot be read.
pub(super) async fn run(
    trial: &Trial,
    (program, folder): (&Path, &Path),
    (before, peers): (&[Finding], &[Peer]),
    limit: Duration,
) -> Result<Finding, BenchError> {
    let scene = format!("{}.toml", trial.id);
    let mesh = format!("{}.msh", trial.id);
    let text = trial.scene(&mesh).map_err(BenchError::Arguments)?;
    let body = trial.body().map_err(BenchError::Arguments)?;
    let write = |path: &Path, bytes: &[u8]| {
        std::fs::write(path, bytes).map_err(BenchError::unwritable(path))
    };
    write(&folder.join(&scene), text.as_bytes())?;
    write(&folder.join(mesh), &body.msh())?;
    let started = Instant::now();
    let (outcome, lines) = solved((program, folder), &scene, limit).await;
    let wall = started.elapsed().as_secs_f64();
    let known = known(trial, &lines, (before, peers));
    let (verdict, error) = verdict::of(trial, &outcome, &lines, known);
    let count = |path: &str| lines.total(path).and_then(Value::as_i64);
    Ok(Finding {
        verdict,
        error,
        outcome,
        known,
        value: lines.last(&trial.value),
        applications: count("preconditioner_applications").unwrap_or_default(),
        seconds: lines
            .total("seconds/total")
            .and_then(Value::as_f64)
            .unwrap_or(wall),
        warnings: lines.warnings(),
        stability: lines.word("stability").to_owned(),
        falls: lines.falls(),
        instruction_set: lines.word("instruction_set").to_owned(),
        trial: trial.clone(),
    })
}

/// The number that the value of a trial is compared with, where it is one.
fn known(trial: &Trial, lines: &Lines, (before, peers): (&[Finding], &[Peer])) -> Option<Known> {
    let number = match trial.expected() {
        Expected::Number(number, scale) => return Some(Known { number, scale }),
        Expected::Step(step) => lines.of_step(step, &trial.value)?,
        Expected::Row(id, factor) => {
            let other = before.iter().find(|finding| finding.trial.id == id)?;
            other
                .value
                .filter(|_| other.outcome == Outcome::Converged)?
                * factor
        }
        Expected::Peer => peers.iter().find(|peer| peer.knows(&trial.id))?.value,
        Expected::Convergence
        | Expected::Cause(..)
        | Expected::Warning(_)
        | Expected::Said(_)
        | Expected::Stability(_)
        | Expected::Refusal => return None,
    };
    Some(Known::of(number))
}

/// A process on a scene, stopped at the limit.
async fn solved(
    (program, folder): (&Path, &Path),
    scene: &str,
    limit: Duration,
) -> (Outcome, Lines) {
    let mut command = Command::new(program);
    command.args(["solve", "--json", "--quiet"]).arg(scene);
    command.current_dir(folder).stdin(Stdio::null());
    command.kill_on_drop(true);
    match tokio::time::timeout(limit, command.output()).await {
        Err(_) => (Outcome::TimeLimit, Lines::default()),
        Ok(Err(error)) => (Outcome::Crashed(error.to_string()), Lines::default()),
        Ok(Ok(output)) => {
            let lines = Lines::read(&output);
            let ended = lines.steps.last().map(outcome);
            (ended.unwrap_or_else(|| without_result(&output)), lines)
        }
    }
}
