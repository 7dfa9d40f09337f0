//! The gRPC server of the Signorini solver: [`serve`] is used by the binary, by
//! programs that embed the server and by tests alike.
//!
//! The way of a request: `door` (who comes, may it) -> `service` -> `convert` (wire to
//! domain) -> `registry` and `session` (mailbox, one actor each) -> `compute` (solver
//! threads) -> `results` -> `service::streams`. Handlers never compute, solver threads never
//! wait, the outbox of `results` is the only place where the two speeds meet.
//!
//! | room | what it is for | may import |
//! |---|---|---|
//! | `process` | what the operating system gives and tells | nothing |
//! | `fault` | what can be wrong with a request, and its status | nothing |
//! | `config` | settings | `process` |
//! | `watch` | metrics, live page, log, traces, doctor | the above |
//! | `door` | connections and layers before the services | the above |
//! | `convert` | between wire and domain types | `config`, `fault` |
//! | `compute` | solver threads and their queue | `config`, `door`, `watch` |
//! | `journal` | the data folder | `config`, `watch` |
//! | `results` | results on their way to readers | `convert`, `fault` |
//! | `uploads` | meshes, surfaces and prepared data in memory | `convert` and what lies before it |
//! | `fleet` | sessions of several servers | `journal` and what lies before `convert` |
//! | `session` | one actor each | all above |
//! | `registry` | sessions by name, plans, waking | all above |
//! | `data` | backups, checks, exported states | all above |
//! | `service` | handlers and streams | all above |
//! | `serve` | puts the parts together | all |
//!
//! The table stands in `tests/architecture`, which holds the rooms to it. Only
//! `fault::status` makes a gRPC status, only `watch::metrics` names a metric, only `convert`
//! sees both wire and domain types, only `journal` reads and writes files, under names that
//! are digests which the server computed. With a data folder, `session` hands each change to
//! `journal` and shows a result when the disk has it; `registry::wake` brings a session back.
//! In a fleet `registry` asks `fleet` for what it does not have, and `journal` writes through
//! its fence.

#![cfg_attr(
    not(test),
    warn(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing
    )
)]

mod compute;
mod config;
mod convert;
mod data;
mod door;
mod fault;
mod fleet;
mod journal;
mod process;
mod registry;
mod results;
mod serve;
mod service;
mod session;
mod uploads;
mod watch;

pub use config::{Compared, Config, ConfigError, Flags, LogFormat, LogLevel, Settings};
pub use convert::local::scene_and_steps;
pub use data::control::{BackupError, backup, restore};
pub use data::fsck::{Fsck, fsck};
pub use door::access::{
    AccessError, CertificateEnd, Entry, NewToken, Role, TokenFile, certificate_ends,
    certificate_names,
};
pub use door::client_name::{ClientName, ClientNameError};
pub use door::listen::{ListenError, Listener};
#[cfg(feature = "fleet")]
pub use fleet::{Held, HeldError, held, nats_addresses};
pub use journal::Copying;
pub use journal::JournalError;
pub use process::hangup::Hangups;
pub use process::large_pages::LargePages;
pub use process::memory::return_freed_memory;
pub use serve::{ServeError, check, doubts, serve, serve_and_tell};
pub use watch::doctor::{Doctor, Finding, Health, doctor};
pub use watch::log::{LogSwitch, follow_log_level, is_unprintable, start_log};
#[cfg(feature = "fleet")]
pub use watch::page::serve_metrics;
