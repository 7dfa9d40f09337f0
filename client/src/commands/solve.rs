//! `solve`: one scene from its file to its results.

mod run;

use std::time::Instant;

use signorini_client::{NewSession, result_line};
use signorini_proto::v1;

use crate::arguments::SolveArguments;
use crate::connection::Connection;
use crate::exit::{Exit, Failure};
use crate::input::{self, Input};
use crate::output::LineSink;
use crate::progress::{Progress, Visibility};
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
    let mut run = open_run(&arguments, &input)?;
    run.warn(&input.mesh.warnings);
    run.progress.phase("starting");
    let connection = Connection::open(arguments.scene.server.as_ref()).await?;
    let outcome = solve(&connection, &mut run, input).await;
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
    if arguments.out.is_none() {
        scene.output = None;
        return;
    }
    let output = scene.output.get_or_insert_default();
    if output.fields.is_empty() {
        output.fields = DEFAULT_FIELDS.map(i32::from).to_vec();
    }
}

fn open_run(arguments: &SolveArguments, input: &Input) -> Result<Run, Failure> {
    let folder = arguments.out.as_ref();
    let folder = folder.map(|folder| ResultFolder::new(folder, &input.scene, &input.mesh));
    let folder = folder.transpose()?;
    let mut lines = LineSink::default();
    if arguments.scene.json {
        lines = lines.with_stdout();
    }
    if let Some(folder) = &folder {
        lines = lines.with_file(&folder.lines())?;
    }
    let visibility = if arguments.quiet {
        Visibility::Hidden
    } else {
        Visibility::Shown
    };
    let increments = input
        .scene
        .steps
        .iter()
        .map(|step| step.increments.unwrap_or(1).max(1));
    let increments: u64 = increments.map(i64::from).sum::<i64>().unsigned_abs();
    Ok(Run::new(
        lines,
        folder,
        Progress::new(increments, visibility),
        visibility,
    ))
}

async fn solve(connection: &Connection, run: &mut Run, input: Input) -> Result<Exit, Failure> {
    let client = &connection.client;
    run.progress.phase("uploading the mesh");
    let uploaded = client.upload_mesh(input.wire).await;
    // The plan repeats what the server has to say about the mesh.
    uploaded.map_err(|error| error.about(&input.mesh_path))?;
    let steps = input.scene.steps.clone();
    let new = NewSession {
        scene: input.scene,
        ..Default::default()
    };
    let (session, plan) = client.create_session(new).await?;
    run.warn(&plan.warnings);
    run.lines.write(&result_line::plan(&plan))?;
    run.plan = plan;
    run.progress.phase("preparing");
    let outcome = run.drive(client, &session.name, steps).await;
    // The results are here; a session that is already gone is no fault.
    let _gone = client.delete_session(&session.name).await;
    outcome
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
