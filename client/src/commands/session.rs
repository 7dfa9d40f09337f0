//! `session list|show|delete`.

use serde_json::{Value, json};
use signorini_client::Client;
use signorini_proto::v1;

use crate::arguments::{RemoteArguments, SessionCommand};
use crate::exit::{Exit, Failure};
use crate::table;
use crate::text::{bytes, print};

pub(super) async fn run(command: SessionCommand) -> Result<Exit, Failure> {
    match command {
        SessionCommand::List { remote } => {
            let client = Client::connect(&remote.server).await?;
            for session in client.list_sessions().await? {
                show(&session, &remote)?;
            }
        }
        SessionCommand::Show { session, remote } => {
            let client = Client::connect(&remote.server).await?;
            let session = client.get_session(&session).await?;
            show(&session, &remote)?;
            if let Some(plan) = session.plan.as_ref().filter(|_| !remote.json) {
                print(&table::plan(plan))?;
            }
        }
        SessionCommand::Delete { session, remote } => {
            let client = Client::connect(&remote.server).await?;
            client.delete_session(&session).await?;
        }
    }
    Ok(Exit::Ok)
}

fn show(session: &v1::Session, remote: &RemoteArguments) -> Result<(), Failure> {
    let line = if remote.json {
        object(session).to_string()
    } else {
        line(session)
    };
    print(&format!("{line}\n"))
}

fn state(session: &v1::Session) -> String {
    let name = session.state().as_str_name();
    name.trim_start_matches("SESSION_STATE_")
        .to_ascii_lowercase()
}

fn line(session: &v1::Session) -> String {
    format!(
        "{}  {} {}, {} updates accepted, {} finished, {}",
        session.name,
        session.scene_name,
        state(session),
        session.last_accepted_sequence,
        session.last_finished_sequence,
        bytes(session.memory_bytes),
    )
}

fn object(session: &v1::Session) -> Value {
    json!({
        "name": session.name,
        "state": state(session),
        "scene": session.scene_name,
        "mesh": session.mesh,
        "last_accepted_sequence": session.last_accepted_sequence,
        "last_finished_sequence": session.last_finished_sequence,
        "attached": session.attached,
        "memory_bytes": session.memory_bytes,
        "prepared_memory_bytes": session.prepared_memory_bytes,
        "prepared_reused": session.prepared_reused,
    })
}
