//! `config check|show`: the settings of a server, and where each comes from.

use signorini_server::{Flags, Settings};

use crate::arguments::ConfigCommand;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;
use crate::terminal::text::note;

pub(super) fn run(command: ConfigCommand) -> Result<Exit, Failure> {
    match command {
        ConfigCommand::Check { file } => {
            let flags = Flags {
                config: Some(file.clone()),
                ..Flags::default()
            };
            let config = resolved(&flags)?.config;
            let checked = signorini_server::check(&config);
            checked.map_err(|error| {
                Failure::new(Exit::Usage, format!("{}: {error}", file.display()))
            })?;
            for doubt in signorini_server::doubts(&config) {
                note(&format!("{}: warning: {doubt}\n", file.display()));
            }
            print(&format!("{}: no faults\n", file.display()))?;
            let wrong = |error: signorini_server::AccessError| {
                Failure::new(Exit::Usage, format!("{}: {error}", file.display()))
            };
            let ends = signorini_server::certificate_ends(&resolved(&flags)?.config);
            for found in ends.map_err(wrong)? {
                let soon = if found.is_near() {
                    ": renew it now"
                } else {
                    ""
                };
                let (path, days) = (found.path.display(), found.days_left());
                print(&format!("{path}: good for {days} days{soon}\n"))?;
            }
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
