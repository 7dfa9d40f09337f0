//! `fleet status`: who holds which session.

use serde_json::json;
use signorini_server::Held;

use crate::arguments::FleetCommand;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;
use crate::terminal::text::{note, one_line};

pub(super) async fn run(command: FleetCommand) -> Result<Exit, Failure> {
    let FleetCommand::Status { nats, json } = command;
    let held = signorini_server::held(&nats).await;
    let held = held.map_err(|error| Failure::new(Exit::NoServer, error.to_string()))?;
    if held.is_empty() {
        note("no server holds a session\n");
    }
    for one in &held {
        print(&line(one, json))?;
    }
    Ok(Exit::Ok)
}

fn line(held: &Held, is_json: bool) -> String {
    let Held {
        session,
        server,
        epoch,
        renewed,
    } = held;
    if is_json {
        let object = json!({
            "session": session, "server": server, "epoch": epoch, "renewed_seconds": renewed,
        });
        return format!("{object}\n");
    }
    let server = one_line(server);
    format!("{session:40}  {server:32}  epoch {epoch:8}  renewed {renewed} s ago\n")
}
