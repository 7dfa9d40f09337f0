//! `session list|show|delete`.

use std::collections::BTreeMap;
use std::time::{Duration, SystemTime};

use serde_json::{Value, json};
use signorini_proto::v1;
use signorini_proto::v1::shape::Kind;

use crate::arguments::{RemoteArguments, SessionCommand};
use crate::report::table;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;
use crate::terminal::text::{bytes, note, one_line};

pub(super) async fn run(command: SessionCommand) -> Result<Exit, Failure> {
    match command {
        SessionCommand::List { remote } => {
            let client = remote.connect().await?;
            let sessions = client.list_sessions().await?;
            if sessions.is_empty() {
                note(&format!("{} has no sessions\n", remote.server));
            }
            for session in sessions {
                show(&session, &remote)?;
            }
        }
        SessionCommand::Show { session, remote } => {
            let client = remote.connect().await?;
            let session = client.get_session(&session).await?;
            show(&session, &remote)?;
            if let Some(plan) = session.plan.as_ref().filter(|_| !remote.json) {
                print(&table::plan(plan))?;
                for (name, surface) in tools(&session) {
                    print(&format!(
                        "obstacle {} is {}\n",
                        one_line(name),
                        one_line(surface)
                    ))?;
                }
            }
        }
        SessionCommand::Delete { session, remote } => {
            let client = remote.connect().await?;
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
    let now = SystemTime::now();
    let since = |time: Option<prost_types::Timestamp>| {
        let time = SystemTime::try_from(time?).ok()?;
        Some(match now.duration_since(time) {
            Ok(passed) => format!("{} old", span(passed)),
            Err(ahead) => format!("expires in {}", span(ahead.duration())),
        })
    };
    let parts = [
        Some(format!(
            "{} of {} steps done",
            session.last_finished_sequence, session.last_accepted_sequence
        )),
        since(session.create_time),
        since(session.expire_time),
        Some(bytes(session.memory_bytes)),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    format!(
        "{}  {} {}, {}",
        one_line(&session.name),
        one_line(&session.scene_name),
        state(session),
        parts.join(", ")
    )
}

/// A time in its largest unit.
fn span(time: Duration) -> String {
    let seconds = time.as_secs();
    match seconds {
        0..120 => format!("{seconds} s"),
        120..7200 => format!("{} min", seconds / 60),
        7200..172_800 => format!("{} h", seconds / 3600),
        _ => format!("{} days", seconds / 86_400),
    }
}

/// Obstacles of uploaded surfaces, and the names of these.
fn tools(session: &v1::Session) -> Vec<(&str, &str)> {
    let obstacles = session.scene.iter().flat_map(|scene| &scene.obstacles);
    let named = obstacles.filter_map(|obstacle| {
        let surface = match obstacle.shape.as_ref()?.kind.as_ref()? {
            Kind::Surface(tool) => &tool.surface,
            Kind::HeightField(tool) => &tool.grid,
            Kind::DistanceGrid(tool) => &tool.grid,
            Kind::HalfSpace(_)
            | Kind::Sphere(_)
            | Kind::Cylinder(_)
            | Kind::CappedCylinder(_)
            | Kind::Box(_)
            | Kind::Torus(_)
            | Kind::Cone(_) => return None,
        };
        Some((obstacle.name.as_str(), surface.as_str()))
    });
    named.collect()
}

/// Seconds since 1970.
fn seconds(time: Option<prost_types::Timestamp>) -> Option<i64> {
    time.map(|time| time.seconds)
}

fn object(session: &v1::Session) -> Value {
    let tools: BTreeMap<&str, &str> = tools(session).into_iter().collect();
    json!({
        "name": session.name,
        "state": state(session),
        "scene": session.scene_name,
        "mesh": session.mesh,
        "tools": tools,
        "last_accepted_sequence": session.last_accepted_sequence,
        "last_finished_sequence": session.last_finished_sequence,
        "attached": session.attached,
        "memory_bytes": session.memory_bytes,
        "prepared_memory_bytes": session.prepared_memory_bytes,
        "prepared_reused": session.prepared_reused,
        "create_time": seconds(session.create_time),
        "expire_time": seconds(session.expire_time),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_tells_progress_age_and_end() {
        let at = |offset: i64| {
            let now = prost_types::Timestamp::from(SystemTime::now());
            let seconds = now.seconds + offset;
            Some(prost_types::Timestamp { seconds, ..now })
        };
        let session = v1::Session {
            name: "sessions/ring-1".to_owned(),
            scene_name: "ring\u{1b}".to_owned(),
            state: v1::SessionState::Running.into(),
            create_time: at(-600),
            expire_time: at(90_001),
            last_accepted_sequence: 5,
            last_finished_sequence: 2,
            ..Default::default()
        };
        assert_eq!(
            line(&session),
            "sessions/ring-1  ring\\u{1b} running, 2 of 5 steps done, 10 min old, \
             expires in 25 h, 0 B"
        );
    }
}
