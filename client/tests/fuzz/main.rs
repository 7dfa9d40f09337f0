//! No bytes make a reader of the client panic or take memory beyond its budget. The heap is
//! counted, so these campaigns have a program of their own.

#[path = "../common/fuzz/mod.rs"]
mod fuzz;

mod meshes;
mod proto;
mod scene;
mod study;
mod surfaces;
