//! The server's settings: one flat struct, read from TOML, every key with a
//! default. Unknown keys are errors.
//!
//! | file | what it does |
//! |---|---|
//! | `sources` | defaults, file, environment and flags, in this order |
//! | `nearest` | the key that a misspelt one is nearest to |
//! | `shares` | slots of solver threads, limits of the data folder |
//! | `fleet`, `log_lines` | settings of a fleet; how the log is written |

mod compared;
mod fleet;
mod log_lines;
mod nearest;
mod shares;
mod sources;

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::process::limits;

pub use compared::Compared;
pub use log_lines::{LogFormat, LogLevel};
pub(crate) use shares::{Limit, Slots};
pub use sources::{Flags, Settings};

/// Used when the machine's memory cannot be read.
const FALLBACK_BUDGET_BYTES: u64 = 8 << 30;

/// Longest time that a setting or a request may name, seconds: 30 days. Clocks
/// can add it to any instant.
pub(crate) const LONGEST_SECONDS: u64 = 30 * 24 * 3600;

/// Most of anything that is counted: beyond it is a slip of the pen.
const MOST: usize = 1 << 20;
/// Most solver threads of all slots.
const MOST_THREADS: usize = 1 << 16;

/// A setting that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConfigError {
    /// Not TOML, an unknown key or a wrong type.
    #[error("{0}")]
    Syntax(String),
    /// A file or a variable that cannot be used.
    #[error("{origin}: {why}")]
    At {
        /// The file or variable.
        origin: String,
        /// What is wrong with it.
        why: String,
    },
    /// A value outside its range.
    #[error("{key}: must be {range}")]
    Range {
        /// Key of the setting.
        key: &'static str,
        /// Values allowed.
        range: &'static str,
    },
}

/// Settings of one server.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Where the service listens: `127.0.0.1:50051`, `[::1]:50051`,
    /// `localhost:50051` or `unix:/path/to/socket`; port 0 takes a free one. Any other
    /// address needs `tls_certificate`, `tls_key` and `tokens`.
    pub listen: String,
    /// Certificates of the server (PEM), its own first; empty: no transport security.
    pub tls_certificate: String,
    /// Key of the first of them (PEM).
    pub tls_key: String,
    /// Certificates of the authority that has to have signed those of clients (PEM); empty:
    /// clients need none.
    pub tls_client_ca: String,
    /// Token file: every call has to prove a name of it; empty: nobody is asked.
    pub tokens: String,
    /// Sessions that one client may have at one time: a name of the token file, or without
    /// one a user of this machine or another machine; 0: as many as there may be.
    pub maximum_client_sessions: usize,
    /// Bytes that the sessions, tools and imported states of one client may hold in memory when
    /// it adds one; 0: as many as there may be.
    pub maximum_client_bytes: u64,
    /// Calls of one client in a second, over a while: twice as many may come at once; 0: no
    /// limit. A stream is one call. Where tokens are asked for, calls without one count for the
    /// address that they come from.
    pub maximum_client_calls_per_second: u32,
    /// Slots that one client may have at one time; 0: all.
    pub maximum_client_slots: usize,
    /// Whether reflection is served, on a server with tokens to those who have one.
    pub reflection: bool,
    /// Whether gRPC health is served, to everybody who reaches the address.
    pub health: bool,
    /// Where the Prometheus page `/metrics` and the live page `/live` are served, loopback only;
    /// empty: nowhere.
    pub metrics_listen: String,
    /// Solves that run at one time, at least 1.
    pub solver_slots: usize,
    /// Slots that take no work known to be long, so that short work need not wait for
    /// it; of one slot none, and fewer than `solver_slots` in any case.
    pub short_slots: usize,
    /// Threads of each solve; 0: as many as the machine has cores.
    pub threads_per_slot: usize,
    /// Bytes for meshes, prepared data and sessions together; 0: three quarters
    /// of the memory of the machine, or of its control group or address space (`ulimit
    /// -v`) where those have less.
    pub memory_budget_bytes: u64,
    /// Sessions that may exist at one time, at least 1.
    pub maximum_sessions: usize,
    /// Solves of one client that may wait for a slot before new ones are refused, at
    /// least 1. A client is a name of the token file, or without one a user of this machine
    /// or another machine.
    pub maximum_queued: usize,
    /// Seconds that one step may run, those in which it waits for a slot left out; 0 for
    /// no such limit, at most 2 592 000.
    pub maximum_step_seconds: u64,
    /// Connections that may be open at one time, at least 1; fewer where the process
    /// may have fewer descriptors.
    pub maximum_connections: usize,
    /// Connections of one user of the machine, at least 1 and at most half of all.
    pub maximum_client_connections: usize,
    /// Accepted updates that may wait in one session, at least 1.
    pub maximum_in_flight: usize,
    /// Seconds without a call after which a session expires, unless it asks for
    /// another time; 1 to 2 592 000 (30 days).
    pub session_ttl_seconds: u64,
    /// Results whose reports one session keeps; more than `maximum_in_flight`.
    pub retained_results: usize,
    /// Bytes of fields that one session keeps; the newest result always stays.
    pub retained_field_bytes: u64,
    /// Seconds without another message after which a stream gets a heartbeat; 1 to 2 592 000.
    pub heartbeat_seconds: u64,
    /// Seconds in which a request has to be there, beside one for each 64 KiB of it: all of a call
    /// with one message, each message of a stream once it has begun; 1 to 2 592 000.
    pub request_seconds: u64,
    /// Seconds without a message taken after which a stream ends and its session is free for
    /// another; after twice as many its connection is closed, as that of any other answer which
    /// nobody takes; 1 to 2 592 000.
    pub unread_seconds: u64,
    /// Seconds that a shutdown waits for running steps to stop; at most 2 592 000.
    pub drain_seconds: u64,
    /// Data folder: sessions, their updates and results, meshes and tools outlive the
    /// server in it; empty: nothing does.
    pub data: String,
    /// Bytes of results and imported states in the data folder, beyond which the oldest go, but for those
    /// that a session needs; 0: no limit.
    pub data_bytes: u64,
    /// Seconds after which results and imported states in the data folder go, but for those that a session
    /// needs; 0: never.
    pub data_seconds: u64,
    /// How the lines of the log are written, for [`crate::start_log`].
    pub log_format: LogFormat,
    /// The least important lines of the log, for [`crate::start_log`].
    pub log_level: LogLevel,
    /// Collector of OpenTelemetry that gets traces of what is solved, by OTLP over gRPC without
    /// transport security: `http://127.0.0.1:4317`; empty: none. Needs the feature `otlp`.
    pub otlp_endpoint: String,
    /// NATS server with JetStream by which several servers share their sessions:
    /// `nats://127.0.0.1:4222`; empty: this one is alone. Needs the feature `fleet`, and `data`
    /// and `fleet_store`; sessions that the data folder has from before are dropped.
    pub fleet_nats: String,
    /// Folder that all servers of the fleet share, for meshes, tools and large records.
    pub fleet_store: String,
    /// What the server calls itself to the others and to clients that ask it for a session of
    /// another; empty: its address.
    pub fleet_name: String,
    /// Seconds after which a session of a server that is gone is another's; the same in all of a
    /// fleet, 1 to 3600.
    pub fleet_lease_seconds: u64,
    /// Servers of NATS that keep each lease and each record, 1 to 5.
    pub fleet_replicas: usize,
    /// Methods that scenes may name beside the solver's own: the program's, in no file.
    #[serde(skip)]
    pub compared: Compared,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            listen: "127.0.0.1:50051".to_owned(),
            tls_certificate: String::new(),
            tls_key: String::new(),
            tls_client_ca: String::new(),
            tokens: String::new(),
            maximum_client_sessions: 0,
            maximum_client_bytes: 0,
            maximum_client_calls_per_second: 0,
            maximum_client_slots: 0,
            reflection: true,
            health: true,
            metrics_listen: "127.0.0.1:9464".to_owned(),
            solver_slots: 2,
            short_slots: 1,
            threads_per_slot: 0,
            memory_budget_bytes: 0,
            maximum_sessions: 1000,
            maximum_queued: 64,
            maximum_step_seconds: 3600,
            maximum_connections: 4096,
            maximum_client_connections: 2048,
            maximum_in_flight: 64,
            session_ttl_seconds: 900,
            retained_results: 4096,
            retained_field_bytes: 256 << 20,
            heartbeat_seconds: 10,
            request_seconds: 10,
            unread_seconds: 300,
            drain_seconds: 30,
            data: String::new(),
            data_bytes: 0,
            data_seconds: 0,
            log_format: LogFormat::Auto,
            log_level: LogLevel::Info,
            otlp_endpoint: String::new(),
            fleet_nats: String::new(),
            fleet_store: String::new(),
            fleet_name: String::new(),
            fleet_lease_seconds: 6,
            fleet_replicas: 1,
            compared: Compared::default(),
        }
    }
}

impl Config {
    /// A server for one process: a free loopback port, no metrics page.
    pub fn embedded() -> Self {
        Self {
            listen: "127.0.0.1:0".to_owned(),
            metrics_listen: String::new(),
            ..Self::default()
        }
    }

    /// Settings from TOML; keys left out keep their defaults.
    ///
    /// # Errors
    /// [`ConfigError`] with the key or the place in the text.
    pub fn from_toml(text: &str) -> Result<Self, ConfigError> {
        let config: Self =
            toml::from_str(text).map_err(|error| ConfigError::Syntax(nearest::told(&error)))?;
        config.check()?;
        Ok(config)
    }

    /// Every key with its value as TOML writes it, in alphabetical order.
    pub fn keys(&self) -> Vec<(String, String)> {
        let mut keys: Vec<_> = self
            .table()
            .into_iter()
            .map(|(key, value)| (key, value.to_string()))
            .collect();
        keys.sort_unstable();
        keys
    }

    fn table(&self) -> toml::Table {
        // A flat struct of numbers and texts is always a table.
        toml::Table::try_from(self).unwrap_or_default()
    }

    /// Checks every range.
    ///
    /// # Errors
    /// [`ConfigError::Range`] for the first value outside its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        let at_least_one = [
            ("solver_slots", self.solver_slots as u64),
            ("maximum_sessions", self.maximum_sessions as u64),
            ("maximum_queued", self.maximum_queued as u64),
            ("maximum_in_flight", self.maximum_in_flight as u64),
            ("maximum_connections", self.maximum_connections as u64),
            (
                "maximum_client_connections",
                self.maximum_client_connections as u64,
            ),
            ("session_ttl_seconds", self.session_ttl_seconds),
            ("retained_results", self.retained_results as u64),
            ("heartbeat_seconds", self.heartbeat_seconds),
            ("request_seconds", self.request_seconds),
            ("unread_seconds", self.unread_seconds),
        ];
        let times = [
            ("session_ttl_seconds", self.session_ttl_seconds),
            ("heartbeat_seconds", self.heartbeat_seconds),
            ("request_seconds", self.request_seconds),
            ("unread_seconds", self.unread_seconds),
            ("drain_seconds", self.drain_seconds),
            ("maximum_step_seconds", self.maximum_step_seconds),
        ];
        if self.tls_certificate.is_empty() != self.tls_key.is_empty() {
            return Err(range(
                "tls_key",
                "given where tls_certificate is, and only there",
            ));
        }
        if self.tls_certificate.is_empty() && !self.tls_client_ca.is_empty() {
            return Err(range("tls_client_ca", "left out where tls_certificate is"));
        }
        if !self.tls_client_ca.is_empty() && self.tokens.is_empty() {
            let why = "beside tokens, which says what a certificate's common name may do";
            return Err(range("tls_client_ca", why));
        }
        self.check_fleet()?;
        if self.retained_results <= self.maximum_in_flight {
            return Err(range("retained_results", "above maximum_in_flight"));
        }
        let many = self.numbers().into_iter().find(|(_, value)| *value > MOST);
        if let Some((key, _)) = many {
            return Err(range(key, "at most 1048576"));
        }
        let threads = self
            .solver_slots
            .saturating_mul(self.threads_per_slot.max(1));
        if threads > MOST_THREADS {
            let why = "at most 65536, with as many threads of all slots together";
            return Err(range("solver_slots", why));
        }
        let zero = at_least_one.iter().find(|(_, value)| *value == 0);
        let long = times.iter().find(|(_, value)| *value > LONGEST_SECONDS);
        match (zero, long) {
            (Some((key, _)), _) => Err(range(key, "at least 1")),
            (None, Some((key, _))) => Err(range(key, "at most 2592000, which is 30 days")),
            (None, None) => Ok(()),
        }
    }

    /// What is counted, and so held in memory or in tables of the system.
    fn numbers(&self) -> [(&'static str, usize); 9] {
        [
            ("solver_slots", self.solver_slots),
            ("short_slots", self.short_slots),
            ("threads_per_slot", self.threads_per_slot),
            ("maximum_sessions", self.maximum_sessions),
            ("maximum_queued", self.maximum_queued),
            ("maximum_in_flight", self.maximum_in_flight),
            ("maximum_connections", self.maximum_connections),
            (
                "maximum_client_connections",
                self.maximum_client_connections,
            ),
            ("retained_results", self.retained_results),
        ]
    }

    /// Whether the service is at a socket that only its owner may open.
    pub(crate) fn is_private(&self) -> bool {
        self.listen.starts_with("unix:")
    }

    /// The file that says who may do what, where somebody is asked.
    pub(crate) fn token_file(&self) -> Option<&Path> {
        named(&self.tokens)
    }

    /// The files of transport security, where there is any.
    pub(crate) fn tls_files(&self) -> Option<TlsFiles> {
        Some(TlsFiles {
            certificate: named(&self.tls_certificate)?.to_owned(),
            key: named(&self.tls_key)?.to_owned(),
            client_authority: named(&self.tls_client_ca).map(Path::to_owned),
        })
    }

    pub(crate) fn slots(&self) -> Slots {
        Slots {
            count: self.solver_slots,
            short: self.short_slots.min(self.solver_slots.saturating_sub(1)),
            of_client: match self.maximum_client_slots {
                0 => self.solver_slots,
                slots => slots,
            },
            threads: self.threads(),
        }
    }

    pub(crate) fn threads(&self) -> usize {
        match self.threads_per_slot {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads,
        }
    }

    /// Longest time that a step may have a slot.
    pub(crate) fn step_time(&self) -> Option<Duration> {
        let seconds = Some(self.maximum_step_seconds).filter(|seconds| *seconds > 0);
        seconds.map(Duration::from_secs)
    }

    pub(crate) fn budget(&self) -> u64 {
        match self.memory_budget_bytes {
            0 => limits::memory_bytes().map_or(FALLBACK_BUDGET_BYTES, |bytes| bytes / 4 * 3),
            bytes => bytes,
        }
    }

    /// Bytes that the sessions of one client may hold.
    pub(crate) fn client_bytes(&self) -> u64 {
        match self.maximum_client_bytes {
            0 => u64::MAX,
            bytes => bytes,
        }
    }

    pub(crate) fn ttl(&self) -> Duration {
        Duration::from_secs(self.session_ttl_seconds)
    }

    pub(crate) fn heartbeat(&self) -> Duration {
        Duration::from_secs(self.heartbeat_seconds)
    }

    /// Time in which a request has to be there.
    pub(crate) fn request_time(&self) -> Duration {
        Duration::from_secs(self.request_seconds)
    }

    /// Time without a message taken after which a stream ends.
    pub(crate) fn unread_time(&self) -> Duration {
        Duration::from_secs(self.unread_seconds)
    }

    pub(crate) fn drain(&self) -> Duration {
        Duration::from_secs(self.drain_seconds)
    }
}

impl Config {
    /// What the data folder may keep now; none without a limit.
    pub(crate) fn data_limit(&self) -> Option<Limit> {
        let now = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        let age = i64::try_from(self.data_seconds).unwrap_or(i64::MAX);
        let limit = Limit {
            bytes: match self.data_bytes {
                0 => u64::MAX,
                bytes => bytes,
            },
            oldest: match age {
                0 => i64::MIN,
                age => now.as_secs().cast_signed().saturating_sub(age),
            },
        };
        (self.data_bytes > 0 || self.data_seconds > 0).then_some(limit)
    }
}

/// Files of transport security.
#[derive(Clone, Debug)]
pub(crate) struct TlsFiles {
    pub(crate) certificate: PathBuf,
    pub(crate) key: PathBuf,
    /// Of clients.
    pub(crate) client_authority: Option<PathBuf>,
}

fn named(file: &str) -> Option<&Path> {
    (!file.is_empty()).then(|| Path::new(file))
}

fn range(key: &'static str, range: &'static str) -> ConfigError {
    ConfigError::Range { key, range }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_left_out_keep_their_defaults() {
        let config = Config::from_toml("solver_slots = 3").unwrap();
        assert_eq!(config.solver_slots, 3);
        assert_eq!(config.listen, Config::default().listen);
    }

    #[test]
    fn unknown_keys_and_zeros_are_refused_by_name() {
        let unknown = Config::from_toml("solver_slot = 3").unwrap_err();
        assert!(unknown.to_string().contains("solver_slot"));
        let zero = Config::from_toml("heartbeat_seconds = 0").unwrap_err();
        assert!(zero.to_string().contains("heartbeat_seconds"));
    }

    #[test]
    fn numbers_that_no_machine_bears_are_refused_by_name() {
        for text in [
            "solver_slots = 1000000000",
            "solver_slots = 70000",
            "solver_slots = 1000\nthreads_per_slot = 100",
            "short_slots = 9223372036854775807",
            "threads_per_slot = 1000000000",
            "maximum_sessions = 10000000",
            "maximum_connections = 10000000",
            "maximum_in_flight = 2000000\nretained_results = 3000000",
        ] {
            let refused = Config::from_toml(text).unwrap_err().to_string();
            let key = refused.split(':').next().unwrap();
            assert!(text.contains(key), "{text}: {refused}");
            assert!(refused.contains("at most"), "{refused}");
        }
        assert!(Config::from_toml("solver_slots = 512\nthreads_per_slot = 8").is_ok());
    }

    #[test]
    fn times_that_no_clock_can_add_are_refused_by_name() {
        for key in [
            "session_ttl_seconds",
            "heartbeat_seconds",
            "request_seconds",
            "unread_seconds",
            "drain_seconds",
        ] {
            assert!(Config::from_toml(&format!("{key} = {LONGEST_SECONDS}")).is_ok());
            let long = Config::from_toml(&format!("{key} = {}", i64::MAX)).unwrap_err();
            assert!(long.to_string().contains(key), "{long}");
        }
    }
}
