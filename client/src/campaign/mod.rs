//! Runs the cases of a study and keeps their rows.
//!
//! Every case becomes one row: in a log at once, which a process that is killed leaves whole
//! behind, and in a table, in order of the cases, at the end. A case that fails is a row
//! with its cause; only what concerns all of them (no server, a full disk) ends a run.

mod assets;
mod bits;
mod ledger;
mod log;
mod pool;
mod row;
mod server;
mod solver;
mod table;
mod tally;

pub(crate) use ledger::{Ledger, Shared, shared};
pub(crate) use log::{Header, RowLog, Start};
pub(crate) use pool::{Local, run};
pub(crate) use server::Server;
pub(crate) use table::Format;
pub(crate) use tally::Tally;
