//! The gRPC server of the Signorini solver: [`serve`] is used by the binary, by
//! programs that embed the server and by tests alike.
//!
//! The way of a request: `service` and `streams` (door) → `convert` (wire to
//! domain) → `registry` and `session` (mailbox, one actor each) → `compute` (solver
//! threads) → `results` → `streams`. Handlers never compute, solver threads never
//! wait, the outbox of `results` is the only place where the two speeds meet. A
//! room knows those behind it, never those before it: `results` no session, `session`
//! no registry, `registry` no stream. Only `status`
//! makes a gRPC status, only `metrics` names a metric, only `convert` sees both
//! wire and domain types. The server reads and writes no files.

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
mod calls;
mod client_key;
mod compute;
mod config;
mod convert;
mod fair_queue;
mod fault;
mod gates;
mod limits;
mod listen;
mod log;
mod memory;
mod metrics;
mod metrics_page;
mod registry;
mod results;
mod retry;
mod serve;
mod service;
mod session;
mod status;
mod store;
mod streams;
mod surfaces;
mod transport;

pub use config::{Config, ConfigError, LogFormat, LogLevel};
pub use listen::{ListenError, Listener};
pub use log::start_log;
pub use serve::{ServeError, serve};
