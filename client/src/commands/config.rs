//! `config check|show`: the settings of a server, and where each comes from.

use std::collections::BTreeMap;
use std::path::Path;

use signorini_server::Config;

use crate::arguments::{ConfigCommand, ServeArguments};
use crate::exit::{Exit, Failure};
use crate::stdout::print;

pub(super) fn run(command: ConfigCommand) -> Result<Exit, Failure> {
    match command {
        ConfigCommand::Check { file } => {
            let (config, _) = read(Some(&file))?;
            let checked = signorini_server::check(&config);
            checked.map_err(|error| {
                Failure::new(Exit::Usage, format!("{}: {error}", file.display()))
            })?;
            print(&format!("{}: no faults\n", file.display()))?;
        }
        ConfigCommand::Show(arguments) => {
            let (config, origins) = resolved(arguments)?;
            for (key, value) in config.keys() {
                let origin = origins.get(&key).map_or("default", String::as_str);
                print(&format!("{:42} # {origin}\n", format!("{key} = {value}")))?;
            }
        }
    }
    Ok(Exit::Ok)
}

/// Where keys come from that are not at their defaults.
pub(super) type Origins = BTreeMap<String, String>;

/// Settings of a file, and of which keys it has.
fn read(file: Option<&Path>) -> Result<(Config, Origins), Failure> {
    let Some(path) = file else {
        return Ok((Config::default(), Origins::new()));
    };
    let wrong = |error: &dyn std::fmt::Display| {
        Failure::new(Exit::Usage, format!("{}: {error}", path.display()))
    };
    let text = std::fs::read_to_string(path).map_err(|error| wrong(&error))?;
    let config = Config::from_toml(&text).map_err(|error| wrong(&error))?;
    // It has been read as settings already.
    let table: toml::Table = text.parse().unwrap_or_default();
    let origin = path.display().to_string();
    let keys = table.keys().map(|key| (key.clone(), origin.clone()));
    Ok((config, keys.collect()))
}

/// Defaults, then the file, then variables, then flags.
pub(super) fn resolved(arguments: ServeArguments) -> Result<(Config, Origins), Failure> {
    let (mut config, mut origins) = read(arguments.config.as_deref())?;
    let mut given = |key: &str, flag: &str, variable: &str| {
        let origin = if has_flag(flag) { flag } else { variable };
        origins.insert(key.to_owned(), origin.to_owned());
    };
    if let Some(listen) = arguments.listen {
        given("listen", "--listen", "");
        config.listen = listen;
    }
    if let Some(listen) = arguments.metrics_listen {
        given("metrics_listen", "--metrics-listen", "");
        config.metrics_listen = listen;
    }
    if let Some(data) = arguments.data {
        given("data", "--data", "SIGNORINI_DATA");
        config.data = data;
    }
    if let Some(format) = arguments.log_format {
        given("log_format", "--log-format", "SIGNORINI_LOG_FORMAT");
        config.log_format = format;
    }
    if let Some(level) = arguments.log_level {
        given("log_level", "--log-level", "SIGNORINI_LOG_LEVEL");
        config.log_level = level;
    }
    Ok((config, origins))
}

/// Whether the command line has a flag, its value beside or behind it.
fn has_flag(flag: &str) -> bool {
    let is_it = |word: String| {
        let rest = word.strip_prefix(flag);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('='))
    };
    std::env::args().any(is_it)
}
