//! Stories of the methods and elements that the solver is compared with.

#[path = "../common/mod.rs"]
mod common;

mod contact;
mod elements;
mod saddle;
