//! `fetch`: the kept results of a session as the files of `solve --out`.

use std::ops::RangeInclusive;
use std::time::Instant;

use signorini_client::{Client, StepResults};
use signorini_proto::v1;

use super::{lightest_field, open_session};
use crate::arguments::FetchArguments;
use crate::exit::{Exit, Failure};
use crate::output::LineSink;
use crate::progress::Verbosity;
use crate::record::Record;
use crate::results::{Drawings, ResultFolder};

pub(super) async fn run(arguments: FetchArguments, started: Instant) -> Result<Exit, Failure> {
    let client = arguments.remote.connect().await?;
    let (session, scene) = open_session(&client, &arguments.session).await?;
    let lines = LineSink::for_json(arguments.remote.json);
    let mut record = Record::new(lines, &scene.steps, Verbosity::of(arguments.verbose));
    let mut fields = lightest_field(&scene);
    if let Some(out) = &arguments.out {
        let mesh = client.read_mesh(&session.mesh).await?;
        record.open(ResultFolder::new(out, &scene, (&mesh, Drawings::new()))?)?;
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
