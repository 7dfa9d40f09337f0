//! The command line tool `signorini`: solves scenes through the service, starts
//! servers and, with the feature `bench`, measures error against run time.
//!
//! Data go to stdout, everything else to stderr. Exit codes: see [`terminal::exit::Exit`].
//!
//! | room | what it is for | may import |
//! |---|---|---|
//! | `terminal` | text, progress, exit codes | nothing |
//! | `report` | files, tables and a page of results | `terminal` |
//! | `arguments` | what the command line asks for | `terminal`, `report` |
//! | `studies` | runs the cases of a study | the above |
//! | `commands` | one module each | the above |
#![cfg_attr(
    not(test),
    warn(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing
    )
)]

mod arguments;
mod commands;
#[cfg(test)]
mod manual;
mod report;
mod studies;
mod terminal;

use std::process::ExitCode;
use std::time::Instant;

use arguments::Arguments;

/// A server of this process holds large buffers.
#[cfg(feature = "embedded")]
#[global_allocator]
static MEMORY: signorini_server::LargePages = signorini_server::LargePages;

fn main() -> ExitCode {
    let started = Instant::now();
    let arguments = Arguments::of_process();
    let outcome = commands::run(arguments, started);
    outcome.unwrap_or_else(|failure| failure.report()).into()
}
