//! Where settings come from: defaults, then the file, then variables, then flags.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::{Config, ConfigError, LogFormat, LogLevel, nearest};

/// Before the name of a key in capitals: the variable that goes before the file.
const PREFIX: &str = "SIGNORINI_";

/// What the command line of a server takes.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Flags {
    /// Settings (TOML); every key has a default, and a variable SIGNORINI_KEY goes before it
    #[arg(long, value_name = "FILE", env = "SIGNORINI_CONFIG")]
    pub config: Option<PathBuf>,
    /// Where to listen: HOST:PORT or unix:PATH
    #[arg(long, value_name = "ADDRESS")]
    pub listen: Option<String>,
    /// Where the metrics page is served: HOST:PORT, or empty for nowhere
    #[arg(long, value_name = "ADDRESS")]
    pub metrics_listen: Option<String>,
    /// Data folder, made if it is missing; without one nothing outlives the server
    #[arg(long, value_name = "DIR")]
    pub data: Option<String>,
    /// NATS server of a fleet: nats://HOST:PORT
    #[arg(long, value_name = "URL")]
    pub fleet_nats: Option<String>,
    /// Folder that all servers of a fleet share
    #[arg(long, value_name = "DIR")]
    pub fleet_store: Option<String>,
    /// How the log is written on stderr
    #[arg(long, value_name = "FORMAT")]
    pub log_format: Option<LogFormat>,
    /// The least important lines of the log; RUST_LOG goes before it
    #[arg(long, value_name = "LEVEL")]
    pub log_level: Option<LogLevel>,
}

/// Settings, and where those come from that are not at their defaults.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The settings, each in its range.
    pub config: Config,
    /// A file, a variable or a flag, by key.
    pub origins: BTreeMap<String, String>,
}

impl Flags {
    /// The settings of this process.
    ///
    /// # Errors
    /// [`ConfigError::At`] with the file or variable that cannot be used.
    pub fn resolve(&self) -> Result<Settings, ConfigError> {
        self.resolve_with(|name| std::env::var(name).ok())
    }

    fn resolve_with(
        &self,
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<Settings, ConfigError> {
        let mut settings = read(self.config.as_deref())?;
        settings.take_variables(variable)?;
        settings.take_flags(self);
        settings.check()?;
        Ok(settings)
    }

    /// The level of the log that the file names now; none without a file.
    ///
    /// # Errors
    /// As those of [`Flags::resolve`].
    pub fn log_level_now(&self) -> Result<Option<LogLevel>, ConfigError> {
        match self.config {
            Some(_) => Ok(Some(self.resolve()?.config.log_level)),
            None => Ok(None),
        }
    }
}

/// Settings of a file.
fn read(file: Option<&Path>) -> Result<Settings, ConfigError> {
    let (mut config, mut origins) = (Config::default(), BTreeMap::new());
    if let Some(path) = file {
        let origin = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|error| at(&origin, &error))?;
        let wrong = |error: toml::de::Error| at(&origin, &nearest::told(&error));
        config = toml::from_str(&text).map_err(wrong)?;
        let table: toml::Table = text.parse().map_err(wrong)?;
        let keys = table.keys().map(|key| (key.clone(), origin.clone()));
        origins.extend(keys);
    }
    Ok(Settings { config, origins })
}

impl Settings {
    fn take_variables(
        &mut self,
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<(), ConfigError> {
        for (key, value) in self.config.table() {
            let name = format!("{PREFIX}{}", key.to_uppercase());
            let Some(text) = variable(&name) else {
                continue;
            };
            let mut table = self.config.table();
            let given = value_as(&value, &text).map_err(|why| at(&name, &why))?;
            table.insert(key.clone(), given);
            let taken = table.try_into();
            self.config = taken.map_err(|error: toml::de::Error| at(&name, &error.message()))?;
            self.origins.insert(key, name);
        }
        Ok(())
    }

    fn take_flags(&mut self, flags: &Flags) {
        let config = &mut self.config;
        let mut taken = Vec::new();
        let texts = [
            ("listen", &flags.listen, &mut config.listen),
            (
                "metrics_listen",
                &flags.metrics_listen,
                &mut config.metrics_listen,
            ),
            ("data", &flags.data, &mut config.data),
            ("fleet_nats", &flags.fleet_nats, &mut config.fleet_nats),
            ("fleet_store", &flags.fleet_store, &mut config.fleet_store),
        ];
        for (key, flag, value) in texts {
            if let Some(flag) = flag {
                value.clone_from(flag);
                taken.push(key);
            }
        }
        if let Some(format) = flags.log_format {
            config.log_format = format;
            taken.push("log_format");
        }
        if let Some(level) = flags.log_level {
            config.log_level = level;
            taken.push("log_level");
        }
        let named = |key: &str| (key.to_owned(), format!("--{}", key.replace('_', "-")));
        self.origins.extend(taken.into_iter().map(named));
    }

    fn check(&self) -> Result<(), ConfigError> {
        self.config.check().map_err(|error| {
            let key = match &error {
                ConfigError::Range { key, .. } => *key,
                ConfigError::Syntax(_) | ConfigError::At { .. } => "",
            };
            match self.origins.get(key) {
                Some(origin) => at(origin, &error),
                None => error,
            }
        })
    }
}

/// The text of a variable as a value of the kind of `like`.
fn value_as(like: &toml::Value, text: &str) -> Result<toml::Value, String> {
    if like.is_str() {
        return Ok(text.into());
    }
    let wrong = || format!("`{text}` is no {}", like.type_str());
    let read: toml::Table = format!("value = {text}").parse().map_err(|_| wrong())?;
    let value = read.get("value").filter(|value| value.same_type(like));
    value.cloned().ok_or_else(wrong)
}

fn at(origin: &str, why: &dyn std::fmt::Display) -> ConfigError {
    ConfigError::At {
        origin: origin.to_owned(),
        why: why.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_has_a_variable() {
        let texts = |value: &toml::Value, key: &str| match (key, value) {
            ("log_format", _) => "json".to_owned(),
            ("log_level", _) => "warn".to_owned(),
            ("short_slots" | "fleet_replicas", _) => "2".to_owned(),
            (_, toml::Value::Integer(number)) => (number + 100).to_string(),
            (_, toml::Value::Boolean(flag)) => (!flag).to_string(),
            (key, _) => format!("a {key}"),
        };
        let defaults = Config::default().table();
        let expected: BTreeMap<String, String> = defaults
            .iter()
            .map(|(key, value)| {
                (
                    format!("SIGNORINI_{}", key.to_uppercase()),
                    texts(value, key),
                )
            })
            .collect();
        let settings = Flags::default().resolve_with(|name| expected.get(name).cloned());
        let settings = settings.unwrap();
        for (key, value) in settings.config.table() {
            let name = format!("SIGNORINI_{}", key.to_uppercase());
            assert_ne!(value, defaults[&key], "{key}");
            assert_eq!(settings.origins[&key], name);
        }
    }

    #[test]
    fn a_variable_that_does_not_fit_is_told_by_its_name() {
        for (name, text, said) in [
            ("SIGNORINI_SOLVER_SLOTS", "many", "`many` is no integer"),
            ("SIGNORINI_SOLVER_SLOTS", "0", "at least 1"),
            (
                "SIGNORINI_SOLVER_SLOTS",
                "3\nlisten = 5\nx = ",
                "no integer",
            ),
            ("SIGNORINI_HEALTH", "1", "no boolean"),
            ("SIGNORINI_LOG_LEVEL", "loud", "unknown variant `loud`"),
        ] {
            let variable = |asked: &str| (asked == name).then(|| text.to_owned());
            let refused = Flags::default().resolve_with(variable).unwrap_err();
            let refused = refused.to_string();
            assert!(
                refused.contains(name) && refused.contains(said),
                "{refused}"
            );
        }
    }

    #[test]
    fn flags_go_before_variables() {
        let flags = Flags {
            listen: Some("127.0.0.1:1".to_owned()),
            ..Flags::default()
        };
        let settings = flags.resolve_with(|_| None).unwrap();
        assert_eq!(settings.origins["listen"], "--listen");
        let variable = |name: &str| (name == "SIGNORINI_LISTEN").then(|| "127.0.0.1:2".to_owned());
        let settings = flags.resolve_with(variable).unwrap();
        assert_eq!(settings.config.listen, "127.0.0.1:1");
        assert_eq!(settings.origins["listen"], "--listen");
    }
}
