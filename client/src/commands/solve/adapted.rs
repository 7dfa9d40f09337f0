//! Meshes that are refined until goals are known as well as the scene asks (`[accuracy]`).
//!
//! The server solves the rounds; the last mesh is then that of the run, which gives all
//! increments and fields on it.

use std::collections::BTreeMap;

use signorini_client::{Client, refine, result_line};
use signorini_proto::v1;

use super::Known;
use crate::arguments::input::Input;
use crate::commands::Interrupts;
use crate::report::record::Record;
use crate::terminal::exit::{Exit, Failure};

/// Lets the mesh of `input`, which the server has, be one on which the goals are known as well as
/// its scene asks; tells `record` of each mesh.
pub(super) async fn refine(
    client: &Client,
    input: &mut Input,
    record: &mut Record,
) -> Result<Known, Failure> {
    if !refine::is_asked(&input.scene) {
        return Ok(Known::Enough);
    }
    record.progress.phase("solving on the first mesh");
    let mut interrupts = Interrupts::new()?;
    let refined = tokio::select! {
        refined = client.refine_mesh(input.scene.clone(), |round| record.round(line(round))) => {
            refined?
        }
        // The work ends with the call.
        () = interrupts.next() => {
            return Err(Failure::new(Exit::Interrupted, "stopped while the mesh was refined"));
        }
    };
    record.refined(word(refined.end()), &refined.why);
    let is_reached = refined.end() == v1::RefinementEnd::Reached;
    take_over(client, refined, input).await?;
    Ok(if is_reached {
        Known::Enough
    } else {
        Known::LessWell
    })
}

/// Lets the run go on with the last mesh.
async fn take_over(
    client: &Client,
    refined: v1::RefinedMesh,
    input: &mut Input,
) -> Result<(), Failure> {
    input.scene = refined.scene.unwrap_or_default();
    let mesh = client.read_mesh(&input.scene.mesh).await?;
    let warnings = std::mem::take(&mut input.mesh.warnings);
    input.mesh = mesh;
    input.mesh.warnings = warnings;
    Ok(())
}

/// The word used in result lines.
fn word(end: v1::RefinementEnd) -> &'static str {
    match end {
        v1::RefinementEnd::Unspecified => "unknown",
        v1::RefinementEnd::Reached => "reached",
        v1::RefinementEnd::MaxUnknowns => "max_unknowns",
        v1::RefinementEnd::MaxMemory => "max_memory",
        v1::RefinementEnd::MaxTime => "max_time",
        v1::RefinementEnd::MaxRounds => "max_rounds",
        v1::RefinementEnd::Facets => "facets",
        v1::RefinementEnd::Zero => "zero",
        v1::RefinementEnd::NotConverged => "not_converged",
        v1::RefinementEnd::NoRoom => "no_room",
        v1::RefinementEnd::Solver => "solver",
        v1::RefinementEnd::Failed => "failed",
    }
}

fn line(round: v1::RefinementRound) -> result_line::Round {
    let goal = |goal: v1::RefinementGoal| {
        let told = result_line::RoundGoal {
            value: goal.value,
            bound: goal.bound,
            estimate: goal.estimate,
            geometry: goal.geometry,
            tolerance: goal.tolerance,
        };
        (goal.goal, told)
    };
    result_line::Round {
        round: round.round.unsigned_abs(),
        cells: round.cell_count.unsigned_abs(),
        unknowns: round.unknown_count.unsigned_abs(),
        seconds: round.seconds,
        dual_seconds: round.dual_seconds,
        goals: round
            .goals
            .into_iter()
            .map(goal)
            .collect::<BTreeMap<_, _>>(),
        end: None,
        why: None,
    }
}
