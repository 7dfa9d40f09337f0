//! Error against run time: families of scenes over mesh sizes, tolerances and
//! methods, each run a fresh process of this program.
//!
//! [`plan`] lists the runs, [`rounds`] measures them, [`row`] puts errors beside
//! the seconds, [`figures`] draws them and [`page`] gathers the figures. Errors
//! are relative: to the norm of the exact field (A1m), or to a limit that
//! [`limit`] extrapolates from [`reference`] values with its uncertainty.
//!
//! A [`study`] asks a question: it compares choices of methods, drawn by
//! [`study_figures`] and answered by [`answer`] from the rows. [`versus`] sets
//! other solvers beside ours, [`seed`] the experiments that the method comes from.
//!
//! Runs go in rounds, every case once a round, so that the noise of a shared
//! machine spreads over all cases and a budget that ends leaves fewer repeats,
//! not fewer cases. A case's result is its run of median `seconds.total`.

pub(crate) mod answer;
pub(crate) mod chart;
pub(crate) mod cube;
pub(crate) mod estimates;
pub(crate) mod families;
pub(crate) mod family;
pub(crate) mod figures;
pub(crate) mod increments;
pub(crate) mod limit;
pub(crate) mod machine;
pub(crate) mod measure;
pub(crate) mod method;
pub(crate) mod page;
pub(crate) mod peers;
pub(crate) mod plan;
pub(crate) mod reference;
pub(crate) mod rounds;
pub(crate) mod row;
pub(crate) mod seed;
pub(crate) mod shaped;
pub(crate) mod strand;
pub(crate) mod study;
pub(crate) mod study_figures;
pub(crate) mod versus;
pub(crate) mod workshop;
