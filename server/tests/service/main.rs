//! The server over the wire: every call, its refusals and limits, and what operators see.
//!
//! Tests that change or count what the whole process shares are programs of their own:
//! `defects` (fail points), `fuzz_requests`, `fuzz_stream` and `mesh_memory` (the heap).

#[path = "../common/mod.rs"]
mod common;

mod access;
mod alone;
mod cancels;
mod compared;
mod deploy;
mod limits;
mod live;
mod meshes;
mod operation;
mod quotas;
mod raw;
mod refine;
mod request_id;
mod sessions;
mod slow;
mod solve;
mod streams;
mod transport;
