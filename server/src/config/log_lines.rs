//! What the log is and takes.

use serde::{Deserialize, Serialize};

/// How the lines of the log are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum LogFormat {
    /// For people where stderr is a terminal, for programs elsewhere.
    #[default]
    Auto,
    /// For people.
    Text,
    /// One JSON object a line, for programs.
    Json,
}

/// The least important lines that the log takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum LogLevel {
    /// Nothing.
    Off,
    /// Defects of the server.
    Error,
    /// Also what an operator should look at.
    Warn,
    /// Also each session, step and refusal.
    #[default]
    Info,
    /// Also each increment, and streams that break.
    Debug,
    /// Everything, that of libraries included.
    Trace,
}
