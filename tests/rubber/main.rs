//! Stories of rubber at finite strain.

#[path = "../common/mod.rs"]
mod common;

mod beside_rubber;
mod extremes;
mod foams;
mod frames;
mod instability;
mod loaded_supports;
mod pressure;
mod references;
mod refusals;
mod results;
mod rings;
mod rivlin;
mod sheets;
mod stops;
mod turns;
mod verification;
