//! The log of a server program: lines on stderr, for people or as JSON.
//!
//! Clients choose names and texts that get into lines, so control characters are
//! written as escapes: a name can neither begin a line of its own nor command the
//! terminal of whoever reads.

use std::fmt::{self, Write as _};
use std::io::IsTerminal as _;

use tracing::field::Field;
use tracing_subscriber::EnvFilter;
use tracing_subscriber::field::MakeExt as _;
use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::fmt::format::{Writer, debug_fn};

use crate::config::{Config, LogFormat, LogLevel};

/// Sends the log of this process to stderr, as `config` says; `RUST_LOG` goes before
/// its level and may name modules. A log that is set up already stays.
pub fn start_log(config: &Config) {
    let level = EnvFilter::default().add_directive(level(config.log_level).into());
    let filter = EnvFilter::try_from_default_env().unwrap_or(level);
    let lines = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr);
    // A subscriber that is set already keeps its place.
    let _set = match config.log_format {
        LogFormat::Json => lines.json().flatten_event(true).try_init(),
        LogFormat::Text => {
            let colours = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
            let fields = debug_fn(write_field).delimited(" ");
            lines.with_ansi(colours).fmt_fields(fields).try_init()
        }
    };
}

fn level(level: LogLevel) -> LevelFilter {
    match level {
        LogLevel::Off => LevelFilter::OFF,
        LogLevel::Error => LevelFilter::ERROR,
        LogLevel::Warn => LevelFilter::WARN,
        LogLevel::Info => LevelFilter::INFO,
        LogLevel::Debug => LevelFilter::DEBUG,
        LogLevel::Trace => LevelFilter::TRACE,
    }
}

fn write_field(writer: &mut Writer<'_>, field: &Field, value: &dyn fmt::Debug) -> fmt::Result {
    if field.name() != "message" {
        write!(writer, "{}=", field.name())?;
    }
    write!(Escaped(writer), "{value:?}")
}

/// Writes control characters as escapes.
struct Escaped<W>(W);

impl<W: fmt::Write> fmt::Write for Escaped<W> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for character in text.chars() {
            match character.is_control() {
                true => write!(self.0, "{}", character.escape_default())?,
                false => self.0.write_char(character)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped_and_other_text_stays() {
        let mut line = String::new();
        write!(Escaped(&mut line), "a\nb\u{1b}[31m \u{9b}c \u{e9} \"d\"").unwrap();
        assert_eq!(line, "a\\nb\\u{1b}[31m \\u{9b}c \u{e9} \"d\"");
    }
}
