//! Stories of friction.

#[path = "../common/mod.rs"]
mod common;

mod exact;
mod laws;
mod references;
mod rubber;
