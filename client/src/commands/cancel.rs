//! `cancel`: ends a step of a session with its last good state.

use signorini_client::result_line;

use crate::arguments::CancelArguments;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;

pub(super) async fn run(arguments: CancelArguments) -> Result<Exit, Failure> {
    let client = arguments.remote.connect().await?;
    let (session, wanted) = (&arguments.session, arguments.sequence.unwrap_or(0));
    let cancelled = client.cancel_step(session, wanted).await?;
    let line = match (arguments.remote.json, cancelled) {
        (true, _) => result_line::cancel(session, cancelled).to_string(),
        (false, 0) => format!("{session}: {}", idle(wanted)),
        (false, sequence) => format!("{session}: step {sequence} is being cancelled"),
    };
    print(&format!("{line}\n"))?;
    Ok(Exit::Ok)
}

fn idle(wanted: i64) -> String {
    match wanted {
        0 => "no step runs".to_owned(),
        sequence => format!("step {sequence} does not run"),
    }
}
