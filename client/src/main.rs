//! The command line tool `signorini`: solves scenes through the service, starts
//! servers and, with the feature `bench`, measures error against run time.
//!
//! Data go to stdout, everything else to stderr. Exit codes: see [`exit::Exit`].
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
mod campaign;
mod commands;
mod connection;
mod exit;
mod input;
#[cfg(test)]
mod manual;
mod mesh_shape;
mod output;
mod progress;
mod record;
mod report_page;
mod results;
mod results_csv;
mod scene_draft;
mod stdout;
mod table;
mod text;
mod travel;
mod units;
mod whole_file;

use std::process::ExitCode;
use std::time::Instant;

use clap::Parser as _;

use arguments::Arguments;

/// A server of this process holds large buffers.
#[cfg(feature = "embedded")]
#[global_allocator]
static MEMORY: signorini_server::LargePages = signorini_server::LargePages;

fn main() -> ExitCode {
    let started = Instant::now();
    let arguments = Arguments::parse();
    let outcome = commands::run(arguments, started);
    outcome.unwrap_or_else(|failure| failure.report()).into()
}
