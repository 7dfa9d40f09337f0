//! `watch`: the results of a session, kept ones first.

use std::time::Instant;

use signorini_client::ClientError;
use signorini_client::solve::{Events, Watch, WatchOptions};
use signorini_proto::v1;

use super::{Interrupts, lightest_field, open_session};
use crate::arguments::WatchArguments;
use crate::report::record::Record;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::output::LineSink;
use crate::terminal::progress::Verbosity;

pub(super) async fn run(arguments: WatchArguments, started: Instant) -> Result<Exit, Failure> {
    let client = arguments.remote.connect().await?;
    let (session, scene) = open_session(&client, &arguments.session).await?;
    let lines = LineSink::for_json(arguments.remote.json);
    let mut record = Record::new(lines, &scene, Verbosity::of(arguments.verbose));
    record.plan(session.plan.unwrap_or_default(), scene.units.as_ref())?;
    let until = if arguments.follow {
        v1::WatchEnd::Session
    } else {
        v1::WatchEnd::Idle
    };
    let options = WatchOptions {
        fields: lightest_field(&scene),
        iteration_interval: record.iteration_interval(),
        until,
        ..Default::default()
    };
    let Watch { events, .. } = client.watch(&session.name, options).await?;
    let outcome = follow(&mut record, events, until).await;
    record.finish(outcome, started)
}

/// Takes events until the stream ends or the user has seen enough.
async fn follow(
    record: &mut Record,
    mut events: Events,
    until: v1::WatchEnd,
) -> Result<Exit, Failure> {
    let mut interrupts = Interrupts::new()?;
    loop {
        let event = tokio::select! {
            event = events.next() => event,
            () = interrupts.next() => return Ok(Exit::Interrupted),
        };
        match event {
            Ok(Some(event)) => {
                record.take(event)?;
            }
            Ok(None) => return Ok(record.exit()),
            Err(error)
                if is_end(&error) && (until == v1::WatchEnd::Session || !record.is_empty()) =>
            {
                record.progress.note(&error.to_string());
                return Ok(record.exit());
            }
            Err(error) => return Err(error.into()),
        }
    }
}

/// Whether the session is over, and all its results are here.
fn is_end(error: &ClientError) -> bool {
    ["SESSION_DELETED", "SESSION_EXPIRED", "SHUTTING_DOWN"]
        .into_iter()
        .any(|reason| error.is_reason(reason))
}
