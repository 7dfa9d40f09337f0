//! `fetch`: the kept results of a session as the files of `solve --out`, or a tool as an STL file.

use std::ops::RangeInclusive;
use std::time::Instant;

use signorini_client::formats::stl;
use signorini_client::{Client, StepResults, scene_file};
use signorini_proto::v1;
use signorini_proto::v1::shape::Kind;

use super::{lightest_field, open_session};
use crate::arguments::FetchArguments;
use crate::report::record::Record;
use crate::report::results::{Drawings, ResultFolder};
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::output::LineSink;
use crate::terminal::progress::Verbosity;
use crate::terminal::whole_file;

/// What names of tools begin with.
const SURFACES: &str = "surfaces/";

pub(super) async fn run(arguments: FetchArguments, started: Instant) -> Result<Exit, Failure> {
    let client = arguments.remote.connect().await?;
    if arguments.session.starts_with(SURFACES) {
        return surface(&client, &arguments).await;
    }
    let (session, scene) = open_session(&client, &arguments.session).await?;
    let lines = LineSink::for_json(arguments.remote.json);
    let mut record = Record::new(lines, &scene, Verbosity::of(arguments.verbose));
    let mut fields = lightest_field(&scene);
    if let Some(out) = &arguments.out {
        let mesh = client.read_mesh(&session.mesh).await?;
        let drawings = drawings(&client, &scene).await?;
        record.open(ResultFolder::new(out, &scene, (&mesh, drawings))?, &scene)?;
        // Those of the scene's output.
        fields.clear();
    }
    record.plan(
        session.plan.clone().unwrap_or_default(),
        scene.units.as_ref(),
    )?;
    let sequences = match arguments.step {
        Some(sequence) => sequence..=sequence,
        None => kept(&session),
    };
    let outcome = read(&client, &session, sequences, &fields, &mut record).await;
    record.finish(outcome, started)
}

/// A triangulated tool of the server into a file.
async fn surface(client: &Client, arguments: &FetchArguments) -> Result<Exit, Failure> {
    let name = &arguments.session;
    let Some(path) = &arguments.out else {
        let text = format!("{name}: --out names the STL file to write");
        return Err(Failure::new(Exit::Usage, text));
    };
    let surface = client.read_surface(name).await?;
    let written = whole_file::write(path, stl::write(&surface).as_bytes());
    written.map_err(|error| Failure::unwritable(path, &error))?;
    Ok(Exit::Ok)
}

/// What triangulated tools of a scene look like; grids are not sent back.
async fn drawings(client: &Client, scene: &v1::Scene) -> Result<Drawings, Failure> {
    let mut drawings = Drawings::new();
    for obstacle in &scene.obstacles {
        let kind = obstacle
            .shape
            .as_ref()
            .and_then(|shape| shape.kind.as_ref());
        if let Some(Kind::Surface(tool)) = kind {
            let surface = client.read_surface(&tool.surface).await?;
            let drawing = scene_file::facets(&surface, tool.scale.unwrap_or(1.0));
            drawings.insert(obstacle.name.clone(), drawing);
        }
    }
    Ok(drawings)
}

/// Sequences that have results, or may have them by now.
fn kept(session: &v1::Session) -> RangeInclusive<i64> {
    session.first_retained_sequence.max(1)..=session.last_accepted_sequence
}

async fn read(
    client: &Client,
    session: &v1::Session,
    sequences: RangeInclusive<i64>,
    fields: &[v1::FieldName],
    record: &mut Record,
) -> Result<Exit, Failure> {
    let (name, accepted) = (&session.name, session.last_accepted_sequence);
    for sequence in sequences {
        let ended = match client.step_results(name, sequence, fields).await {
            Ok(results) => take(results, record).await?,
            Err(error) if error.is_reason("SEQUENCE_NOT_RETAINED") => {
                record.progress.note(&error.to_string());
                continue;
            }
            Err(error) if error.is_reason("STEP_NOT_FOUND") && sequence <= accepted => None,
            Err(error) => return Err(error.into()),
        };
        if ended.is_none() {
            record.progress.note(&format!(
                "{name} is not finished: step {sequence} of {accepted} is not done; \
                 what is there is fetched"
            ));
            break;
        }
    }
    Ok(record.exit())
}

/// Takes the results of a step; how it ended, `None` while it has not.
async fn take(
    mut results: StepResults,
    record: &mut Record,
) -> Result<Option<v1::Termination>, Failure> {
    let mut ended = None;
    while let Some(increment) = results.next().await? {
        ended = record.add(increment)?;
    }
    Ok(ended)
}
