//! `solve`: one scene from its file to its results.

mod run;

use std::path::Path;
use std::time::Instant;

use signorini_client::formats::msh::MeshFile;
use signorini_client::{NewSession, result_line};
use signorini_proto::v1;

use crate::arguments::SolveArguments;
use crate::connection::Connection;
use crate::exit::{Exit, Failure};
use crate::input::{self, Input};
use crate::output::LineSink;
use crate::progress::Visibility;
use crate::results::ResultFolder;
use crate::table;
use crate::text::{note, print};
use run::Run;

/// Fields written with `--out` when the scene names none.
const DEFAULT_FIELDS: [v1::FieldName; 5] = [
    v1::FieldName::Displacement,
    v1::FieldName::Pressure,
    v1::FieldName::ContactPressure,
    v1::FieldName::Gap,
    v1::FieldName::ContactState,
];

pub(super) async fn run(arguments: SolveArguments, started: Instant) -> Result<Exit, Failure> {
    let mut input = input::load(&arguments.scene)?;
    complete(&mut input.scene, &arguments);
    let mut run = new_run(&arguments, &input.scene.steps);
    run.warn(&input.mesh.warnings);
    run.progress.phase("starting");
    let connection = Connection::open(arguments.scene.server.as_ref()).await?;
    let outcome = solve(&connection, &mut run, input, arguments.out.as_deref()).await;
    connection.close().await;
    run.progress.clear();
    finish(run, outcome, &arguments, started)
}

/// Adds to the scene what the arguments ask for.
fn complete(scene: &mut v1::Scene, arguments: &SolveArguments) {
    if arguments.verify {
        scene.solver.get_or_insert_default().verify = true;
    }
    if scene.steps.is_empty() {
        scene.steps.push(v1::LoadStep::default());
    }
    let output = scene.output.get_or_insert_default();
    if arguments.out.is_none() {
        // Nobody takes the fields; the other keys are checked all the same.
        output.fields.clear();
    } else if output.fields.is_empty() {
        output.fields = DEFAULT_FIELDS.map(i32::from).to_vec();
    }
}

fn new_run(arguments: &SolveArguments, steps: &[v1::LoadStep]) -> Run {
    let mut lines = LineSink::default();
    if arguments.scene.json {
        lines = lines.with_stdout();
    }
    let visibility = if arguments.quiet {
        Visibility::Hidden
    } else {
        Visibility::Shown
    };
    let increments = steps.iter().map(|step| step.increments.unwrap_or(1).max(1));
    let increments: u64 = increments.map(i64::from).sum::<i64>().unsigned_abs();
    Run::new(lines, increments, visibility)
}

async fn solve(
    connection: &Connection,
    run: &mut Run,
    input: Input,
    out: Option<&Path>,
) -> Result<Exit, Failure> {
    let client = &connection.client;
    run.progress.phase("uploading the mesh");
    let uploaded = client.upload_mesh(input.wire).await;
    // The plan repeats what the server has to say about the mesh.
    uploaded.map_err(|error| error.about(&input.mesh_path))?;
    let new = NewSession {
        scene: input.scene.clone(),
        ..Default::default()
    };
    let (session, plan) = client.create_session(new).await?;
    let steps = input.scene.steps.clone();
    let outcome = match begin(run, plan, out, &input.scene, &input.mesh) {
        Ok(()) => run.drive(client, &session.name, steps).await,
        Err(failure) => Err(failure),
    };
    // The results are here; a session that is already gone is no fault.
    let _gone = client.delete_session(&session.name).await;
    outcome
}

/// Writes the plan. Only a scene that is accepted may replace earlier results.
fn begin(
    run: &mut Run,
    plan: v1::Plan,
    out: Option<&Path>,
    scene: &v1::Scene,
    mesh: &MeshFile,
) -> Result<(), Failure> {
    if let Some(out) = out {
        run.open(ResultFolder::new(out, scene, mesh)?)?;
    }
    run.warn(&plan.warnings);
    run.lines.write(&result_line::plan(&plan))?;
    run.plan = plan;
    run.progress.phase("preparing");
    Ok(())
}

/// Summary and table, also of a run that failed half-way.
fn finish(
    mut run: Run,
    outcome: Result<Exit, Failure>,
    arguments: &SolveArguments,
    started: Instant,
) -> Result<Exit, Failure> {
    if run.reports.is_empty() {
        return outcome;
    }
    let wall_seconds = started.elapsed().as_secs_f64();
    run.lines
        .write(&run.totals.summary(wall_seconds, peak_memory()))?;
    if !arguments.quiet {
        let mut text = table::results(&run.plan, &run.reports);
        if let Some(folder) = &run.folder {
            text.push_str(&format!(
                "{:<18} {}\n",
                "written",
                folder.series().display()
            ));
        }
        if arguments.scene.json {
            note(&text)
        } else {
            print(&text)?
        }
    }
    outcome
}

/// Peak resident memory of this process in bytes, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}
