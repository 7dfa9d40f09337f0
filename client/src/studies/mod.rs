//! Runs the cases of a study and keeps their rows.
//!
//! Every case becomes one row: in a log at once, which a process that is killed leaves whole
//! behind, and in a table, in order of the cases, at the end. A case that fails is a row
//! with its cause; only what concerns all of them (no server, a full disk) ends a run. What a
//! study is, the library says (`signorini_client::study`).
//!
//! | file | what it does |
//! |---|---|
//! | `pool`, `solver`, `server` | cases at one time, each on a server |
//! | `queue` | cases of a study for many workers |
//! | `assets` | scenes and meshes that cases share |
//! | `row`, `log`, `ledger`, `tally` | rows, as they come |
//! | `table` | rows in order, as CSV or Parquet |
//! | `bits` | which cases are done, in few bytes |

mod assets;
mod bits;
mod ledger;
mod log;
mod pool;
#[cfg(feature = "fleet")]
mod queue;
mod row;
mod server;
mod solver;
mod table;
mod tally;

#[cfg(feature = "fleet")]
pub(crate) use assets::Assets;
pub(crate) use ledger::{Ledger, Shared, shared};
pub(crate) use log::{Header, RowLog, Start};
#[cfg(feature = "fleet")]
pub(crate) use pool::first_scene;
pub(crate) use pool::{Local, run};
#[cfg(feature = "fleet")]
pub(crate) use queue::{Gauges, Manifest, Queue, Queued, Worker, name_of, run_study, work};
pub(crate) use server::Server;
#[cfg(feature = "fleet")]
pub(crate) use solver::Fields;
pub(crate) use table::Format;
pub(crate) use tally::Tally;
