//! Stories of the methods that the solver is compared with.

#[path = "../../../../tests/common/mod.rs"]
mod common;
mod harness;

mod contact;
mod friction;
mod plans;
mod saddle;
