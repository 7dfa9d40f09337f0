//! Error against run time: families of scenes over mesh sizes, tolerances and
//! methods, each run a fresh process of the program `signorini`.
//!
//! [`run`] does what the [`Arguments`] ask for. `plan` lists the runs, `rounds`
//! measures them, `row` puts errors beside the seconds, `figures` draws them and
//! `page` gathers the figures. Errors are relative: to the norm of the exact field
//! (A1m), or to a limit that `limit` extrapolates from `reference` values with its
//! uncertainty.
//!
//! A `study` asks a question: it compares choices of methods, drawn by
//! `study_figures` and answered by the table that `answer` takes from the rows. One of
//! them, `extremes`, has rows of its own: cases whose result is known without the solver.
//! `recorded` has the runs of methods that are gone; `versus` sets other solvers beside ours, `seed` the experiments that the method
//! comes from; `summary` says in three sentences what follows.
//!
//! Runs go in rounds, every case once a round, so that the noise of a shared
//! machine spreads over all cases and a budget that ends leaves fewer repeats,
//! not fewer cases. A case's result is its run of median `seconds.total`.
//!
//! The bench knows the solver by its command line and result lines only: neither
//! the library nor the client is linked.
#![cfg_attr(
    not(test),
    warn(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing
    )
)]

mod answer;
mod arguments;
mod axis;
mod chart;
mod command;
mod commented;
mod cube;
mod error;
mod estimates;
mod extent;
mod extremes;
mod families;
mod family;
mod figures;
mod increments;
mod limit;
mod limits;
mod machine;
mod measure;
mod method;
mod outcome;
mod page;
mod peers;
mod picture;
mod pictures;
mod plan;
mod recorded;
mod reference;
mod results;
mod rounds;
mod row;
#[cfg(test)]
mod samples;
mod seed;
mod shaped;
mod strand;
mod study;
mod study_figures;
mod summary;
mod table;
mod text;
mod versus;
mod workshop;

pub use arguments::Arguments;
pub use command::{End, Finished, Watched, run};
pub use error::BenchError;
