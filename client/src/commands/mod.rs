//! The commands, one module each.

mod completions;
mod mesh;
mod plan;
mod serve;
mod session;
mod solve;

use std::time::Instant;

use crate::arguments::{Arguments, Command};
use crate::exit::{Exit, Failure};

/// Runs a command. `started` is when the process began.
pub(crate) fn run(arguments: Arguments, started: Instant) -> Result<Exit, Failure> {
    let runtime = tokio::runtime::Runtime::new()
        .map_err(|error| Failure::new(Exit::Server, format!("no runtime: {error}")))?;
    match arguments.command {
        Command::Solve(arguments) => runtime.block_on(Box::pin(solve::run(arguments, started))),
        Command::Plan(arguments) => runtime.block_on(plan::run(arguments)),
        Command::Serve(arguments) => runtime.block_on(serve::run(arguments)),
        Command::Mesh(command) => runtime.block_on(mesh::run(command)),
        Command::Session(command) => runtime.block_on(session::run(command)),
        Command::Completions { shell } => completions::run(shell),
    }
}
