//! `solve`: one scene from its file to its results.

mod accuracy;
mod adapted;
mod detach;
mod run;

use std::path::Path;
use std::time::{Duration, Instant};

use signorini_client::solve::PATIENCE;
use signorini_client::{NewSession, session_id};
use signorini_proto::v1;

use crate::arguments::SolveArguments;
use crate::arguments::connection::Connection;
use crate::arguments::input::{self, Input};
use crate::report::record::Record;
use crate::report::results::{DEFAULT_FIELDS, ResultFolder};
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::output::LineSink;
use crate::terminal::progress::Verbosity;
use run::Run;

pub(super) async fn run(arguments: SolveArguments, started: Instant) -> Result<Exit, Failure> {
    if arguments.detach {
        return Box::pin(detach::run(arguments)).await;
    }
    let mut input = input::load(&arguments.scene)?;
    complete(&mut input, &arguments)?;
    let patience = arguments.patience.map_or(PATIENCE, Duration::from_secs);
    let mut run = Run::new(record(&arguments, &input.scene), patience);
    run.record.input(&input.mesh.warnings);
    run.record.progress.phase("starting");
    let connection = Connection::open(&arguments.scene).await?;
    let outcome = solve(&connection, &mut run, input, arguments.out.as_deref()).await;
    connection.close().await;
    run.record.finish(outcome, started)
}

/// Whether goals are known as well as the scene asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Known {
    /// They are, or nothing is asked.
    Enough,
    /// A limit came first.
    LessWell,
}

impl Known {
    /// How a run ends that would end with `exit` otherwise.
    fn exit(self, exit: Exit) -> Exit {
        if self != Self::Enough && exit == Exit::Ok {
            Exit::Inaccurate
        } else {
            exit
        }
    }
}

/// Adds to the scene what the arguments ask for.
fn complete(input: &mut Input, arguments: &SolveArguments) -> Result<(), Failure> {
    let scene = &mut input.scene;
    if arguments.accuracy {
        accuracy::bound_forces(scene, input.mesh.vertices_per_cell - 1)?;
    }
    if arguments.verify {
        scene.solver.get_or_insert_default().verify = true;
    }
    if scene.steps.is_empty() {
        scene.steps.push(v1::LoadStep::default());
    }
    let output = scene.output.get_or_insert_default();
    if arguments.out.is_none() && !arguments.detach {
        // Nobody takes the fields; the other keys are checked all the same.
        output.fields.clear();
    } else if output.fields.is_empty() {
        output.fields = DEFAULT_FIELDS.map(i32::from).to_vec();
    }
    // Where the pressure is written, so is its path, which no scene in space has.
    let fields = &mut output.fields;
    let [pressure, path] = [v1::FieldName::ContactPressure, v1::FieldName::ContactPath];
    if fields.contains(&pressure.into()) && !fields.contains(&path.into()) {
        fields.push(path.into());
    }
    Ok(())
}

fn record(arguments: &SolveArguments, scene: &v1::Scene) -> Record {
    let lines = LineSink::for_json(arguments.json);
    Record::new(lines, scene, verbosity(arguments))
}

fn verbosity(arguments: &SolveArguments) -> Verbosity {
    if arguments.quiet {
        Verbosity::Quiet
    } else {
        Verbosity::of(arguments.verbose)
    }
}

async fn solve(
    connection: &Connection,
    run: &mut Run,
    mut input: Input,
    out: Option<&Path>,
) -> Result<Exit, Failure> {
    let session_id = session_id();
    let client = &connection.client.of_session(&session_id);
    run.record.progress.phase("uploading the mesh");
    // The plan repeats what the server has to say about the mesh.
    input.upload(client).await?;
    let refined = adapted::refine(client, &mut input, &mut run.record);
    let known = Box::pin(refined).await?;
    let new = NewSession {
        scene: input.scene.clone(),
        session_id,
        ..Default::default()
    };
    let (session, plan) = client.create_session(new).await?;
    let steps = input.scene.steps.clone();
    let outcome = match begin(&mut run.record, plan, &mut input, out) {
        Ok(()) => run.drive(client, &session.name, steps).await,
        Err(failure) => Err(failure),
    };
    // The results are here; a session that is already gone is no fault.
    let _gone = client.delete_session(&session.name).await;
    outcome.map(|exit| known.exit(exit))
}

/// Writes the plan. Only a scene that is accepted may replace earlier results.
fn begin(
    record: &mut Record,
    plan: v1::Plan,
    input: &mut Input,
    out: Option<&Path>,
) -> Result<(), Failure> {
    if let Some(out) = out {
        let picture = (&input.mesh, std::mem::take(&mut input.drawings));
        let folder = ResultFolder::new(out, &input.scene, picture)?;
        record.open(folder, &input.scene)?;
    }
    record.plan(plan, input.scene.units.as_ref())?;
    record.progress.phase("preparing");
    Ok(())
}
