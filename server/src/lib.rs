//! The gRPC server of the Signorini solver: [`serve`] is used by the binary, by
//! programs that embed the server and by tests alike.
//!
//! The way of a request: `service` and `streams` (door) → `convert` (wire to
//! domain) → `registry` and `session` (mailbox, one actor each) → `compute` (solver
//! threads) → `results` → `streams`. Before the door `access` asks who comes and what that one may do. Handlers never compute, solver threads never
//! wait, the outbox of `results` is the only place where the two speeds meet. A
//! room knows those behind it, never those before it: `results` no session, `session`
//! no registry, `registry` no stream. Only `status`
//! makes a gRPC status, only `metrics` names a metric, only `convert` sees both
//! wire and domain types, only `journal` reads and writes files, under names that are
//! digests which the server computed. With a data folder, `session` hands each change to
//! `journal` and shows a result when the disk has it; `wake` brings a session back. In a fleet `registry`
//! asks `fleet` for what it does not have, and `journal` writes through its fence.

#![cfg_attr(
    not(test),
    warn(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing
    )
)]

mod accept;
mod access;
mod calls;
mod client_key;
mod client_name;
mod compute;
mod config;
mod control;
mod convert;
mod doctor;
mod fair_queue;
mod fault;
mod fleet;
mod fsck;
mod gates;
mod hangup;
mod journal;
mod large_pages;
mod limits;
mod listen;
mod log;
mod memory;
mod metrics;
mod metrics_page;
mod planning;
mod registry;
mod request_id;
mod results;
mod retry;
mod serve;
mod service;
mod session;
mod states;
mod status;
mod store;
mod streams;
mod surfaces;
mod traces;
mod transport;
mod upkeep;
mod wake;

pub use access::{AccessError, Entry, NewToken, Role, TokenFile};
pub use client_name::{ClientName, ClientNameError};
pub use config::{Config, ConfigError, Flags, LogFormat, LogLevel, Settings};
pub use control::{BackupError, backup, restore};
pub use doctor::{Doctor, Finding, Health, doctor};
#[cfg(feature = "fleet")]
pub use fleet::{Held, HeldError, held, nats_addresses};
pub use fsck::{Fsck, fsck};
pub use hangup::Hangups;
pub use journal::JournalError;
pub use large_pages::LargePages;
pub use listen::{ListenError, Listener};
pub use log::{LogSwitch, follow_log_level, start_log};
pub use memory::return_freed_memory;
#[cfg(feature = "fleet")]
pub use metrics_page::serve_metrics;
pub use serve::{ServeError, check, serve, serve_and_tell};
