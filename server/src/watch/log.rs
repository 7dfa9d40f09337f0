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
use crate::process::hangup::Hangups;

/// Lines of calls that change something.
const AUDIT: &str = "audit=info";

/// Changes the level of the log of this process while it runs.
pub struct LogSwitch(Box<dyn Fn(EnvFilter) -> bool + Send + Sync>);

/// Sends the log of this process to stderr, as `config` says; `RUST_LOG` goes before
/// its level and may name modules. A log that is set up already stays. The switch of its
/// level, where something else does not go before it.
pub fn start_log(config: &Config) -> Option<LogSwitch> {
    let given = EnvFilter::try_from_default_env().ok();
    let is_given = given.is_some();
    let filter = given.unwrap_or_else(|| default_filter(config.log_level));
    let lines = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        // Whoever reads the log may leave: that is no reason to end a call by a panic.
        .log_internal_errors(false);
    // A subscriber that is set already keeps its place.
    let is_terminal = std::io::stderr().is_terminal();
    let is_text = match config.log_format {
        LogFormat::Auto => is_terminal,
        LogFormat::Text => true,
        LogFormat::Json => false,
    };
    let switch = if is_text {
        let colours = is_terminal && std::env::var_os("NO_COLOR").is_none();
        let fields = debug_fn(write_field).delimited(" ");
        let lines = lines.with_ansi(colours).fmt_fields(fields);
        let lines = lines.with_filter_reloading();
        let handle = lines.reload_handle();
        let change = move |filter| handle.reload(filter).is_ok();
        lines.try_init().map(|()| LogSwitch(Box::new(change)))
    } else {
        let lines = lines.json().flatten_event(true).with_filter_reloading();
        let handle = lines.reload_handle();
        let change = move |filter| handle.reload(filter).is_ok();
        lines.try_init().map(|()| LogSwitch(Box::new(change)))
    };
    switch.ok().filter(|_| !is_given)
}

/// Takes up the level that `read` finds at each hangup, none where no file names one; never
/// returns. Without a switch a hangup changes nothing.
pub async fn follow_log_level(
    switch: Option<LogSwitch>,
    mut hangups: Hangups,
    read: impl Fn() -> Result<Option<LogLevel>, String>,
) {
    loop {
        hangups.next().await;
        take_up(switch.as_ref(), read());
    }
}

fn take_up(switch: Option<&LogSwitch>, found: Result<Option<LogLevel>, String>) {
    match (switch, found) {
        (None, _) => tracing::info!("the level of the log stays: RUST_LOG names what it takes"),
        (_, Ok(None)) => tracing::info!("the level of the log stays: there is no file of settings"),
        (Some(switch), Ok(Some(level))) if (switch.0)(default_filter(level)) => {
            tracing::info!(?level, "level of the log set");
        }
        (_, Ok(Some(_))) => tracing::error!("the level of the log cannot change any more"),
        (_, Err(why)) => tracing::error!(why, "the level of the log stays"),
    }
}

/// Lines of the level, and who changed what whatever the level, unless nothing is written.
fn default_filter(least: LogLevel) -> EnvFilter {
    let filter = EnvFilter::default().add_directive(level(least).into());
    match (least, AUDIT.parse()) {
        (LogLevel::Off, _) | (_, Err(_)) => filter,
        (_, Ok(audit)) => filter.add_directive(audit),
    }
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

/// Whether a character moves a cursor, breaks a line, turns the direction of writing or is not seen
/// at all: control and format characters of Unicode, and its separators of lines and paragraphs.
/// Text of others that has one is written with an escape in its place.
pub fn is_unprintable(character: char) -> bool {
    character.is_control()
        || matches!(character,
            '\u{ad}' | '\u{600}'..='\u{605}' | '\u{61c}' | '\u{6dd}' | '\u{70f}' | '\u{180e}'
            | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}'
            | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}

/// Writes unprintable characters as escapes.
struct Escaped<W>(W);

impl<W: fmt::Write> fmt::Write for Escaped<W> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for character in text.chars() {
            if is_unprintable(character) {
                write!(self.0, "{}", character.escape_default())?
            } else {
                self.0.write_char(character)?
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
        line.clear();
        write!(
            Escaped(&mut line),
            "a\u{2028}b\u{200b}c\u{202e}d\u{feff}e\u{301}"
        )
        .unwrap();
        assert_eq!(line, "a\\u{2028}b\\u{200b}c\\u{202e}d\\u{feff}e\u{301}");
    }
}
