//! `config check|show`: the settings of a server, and where each comes from.

use signorini_server::{Flags, Settings};

use crate::arguments::ConfigCommand;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;

pub(super) fn run(command: ConfigCommand) -> Result<Exit, Failure> {
    match command {
        ConfigCommand::Check { file } => {
            let flags = Flags {
                config: Some(file.clone()),
                ..Flags::default()
            };
            let checked = signorini_server::check(&resolved(&flags)?.config);
            checked.map_err(|error| {
                Failure::new(Exit::Usage, format!("{}: {error}", file.display()))
            })?;
            print(&format!("{}: no faults\n", file.display()))?;
        }
        ConfigCommand::Show { serve, origin: _ } => {
            let settings = resolved(&serve.flags)?;
            for (key, value) in settings.config.keys() {
                let origin = settings.origins.get(&key);
                let origin = origin.map_or("default", String::as_str);
                print(&format!("{:42} # {origin}\n", format!("{key} = {value}")))?;
            }
        }
    }
    Ok(Exit::Ok)
}

/// The settings of this process.
pub(super) fn resolved(flags: &Flags) -> Result<Settings, Failure> {
    let wrong = |error: signorini_server::ConfigError| Failure::new(Exit::Usage, error.to_string());
    flags.resolve().map_err(wrong)
}
