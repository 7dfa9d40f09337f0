//! `solve --detach`: hands a scene with all its steps to a server and leaves.

use std::time::Duration;

use signorini_client::solve::{Attach, Event, Solve};
use signorini_client::{Client, ClientError, NewSession, result_line, session_id};
use signorini_proto::v1;

use super::complete;
use crate::arguments::SolveArguments;
use crate::arguments::input::{self, Input};
use crate::commands::Interrupts;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;
use crate::terminal::text::note;

/// Time to live of a session whose client has left.
const DAY: Duration = Duration::from_secs(24 * 3600);
/// Between two questions whether all steps are accepted; doubles.
const FIRST_PAUSE: Duration = Duration::from_millis(5);
const LONGEST_PAUSE: Duration = Duration::from_millis(500);

pub(super) async fn run(arguments: SolveArguments) -> Result<Exit, Failure> {
    let Some(server) = &arguments.scene.server else {
        let message = "--detach needs --server URL, or SIGNORINI_SERVER: \
                       a server of this process ends with it";
        return Err(Failure::new(Exit::Usage, message));
    };
    let mut input = input::load(&arguments.scene)?;
    complete(&mut input, &arguments)?;
    let client = Client::connect_with(server, &arguments.scene.access.read()?).await?;
    let ttl = arguments.ttl.map_or(DAY, Duration::from_secs);
    let tell = |warnings: &[String]| {
        for warning in warnings.iter().filter(|_| !arguments.quiet) {
            note(&format!("warning: {warning}\n"));
        }
    };
    tell(&input.mesh.warnings);
    let steps = input.scene.steps.clone();
    let name = arguments.name.clone().unwrap_or_else(session_id);
    let client = client.of_session(&name);
    let (session, plan) = create(&client, input, name, ttl).await?;
    tell(&plan.warnings);
    let exit = hand_over(&client, &session.name, steps).await;
    if exit != Ok(Exit::Ok) {
        // Nobody gets its name, unless it cannot be deleted.
        if client.delete_session(&session.name).await.is_err() {
            note(&format!("{} may still be there\n", session.name));
        }
        return exit;
    }
    let line = if arguments.json {
        result_line::session(&session.name).to_string()
    } else {
        session.name
    };
    print(&format!("{line}\n"))?;
    Ok(Exit::Ok)
}

async fn create(
    client: &Client,
    mut input: Input,
    name: String,
    ttl: Duration,
) -> Result<(v1::Session, v1::Plan), Failure> {
    input.upload(client).await?;
    let new = NewSession {
        scene: client.fine_enough(input.scene).await?,
        session_id: name,
        ttl: Some(ttl),
        on_disconnect: v1::DisconnectPolicy::FinishStep,
    };
    Ok(client.create_session(new).await?)
}

/// Sends the steps; an interrupt gives up.
async fn hand_over(
    client: &Client,
    session: &str,
    steps: Vec<v1::LoadStep>,
) -> Result<Exit, Failure> {
    let mut interrupts = Interrupts::new()?;
    tokio::select! {
        sent = send(client, session, steps) => sent.map(|()| Exit::Ok),
        () = interrupts.next() => Ok(Exit::Interrupted),
    }
}

/// Returns when every step is accepted. The results on the way are taken so that
/// further steps find room; the server keeps them.
async fn send(client: &Client, session: &str, steps: Vec<v1::LoadStep>) -> Result<(), Failure> {
    let attach = Attach {
        on_disconnect: v1::DisconnectPolicy::FinishStep,
        iteration_interval: Some(DAY),
        ..Default::default()
    };
    let Solve {
        mut updates,
        mut events,
        ..
    } = client.solve(session, attach).await?;
    let mut last = 0;
    for step in steps {
        last = updates.load_step(step).await?;
    }
    let mut pause = FIRST_PAUSE;
    while !is_accepted(client, session, last).await? {
        tokio::select! {
            event = events.next() => check(event?)?,
            () = tokio::time::sleep(pause) => pause = (pause * 2).min(LONGEST_PAUSE),
        }
    }
    Ok(())
}

async fn is_accepted(client: &Client, session: &str, last: i64) -> Result<bool, Failure> {
    match client.get_session(session).await {
        Ok(session) => Ok(session.last_accepted_sequence >= last),
        // The stream says when its patience is over.
        Err(ClientError::Unreachable { .. }) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

fn check(event: Option<Event>) -> Result<(), Failure> {
    match event {
        Some(Event::Rejected { refusal, .. }) => Err(Failure::from(&*refusal)),
        Some(
            Event::Increment(_)
            | Event::Iteration(_)
            | Event::Heartbeat(_)
            | Event::ConnectionLost { .. }
            | Event::Reconnected { .. },
        ) => Ok(()),
        None => Err(ClientError::Closed.into()),
    }
}
