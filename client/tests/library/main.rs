//! The client library against a server in the process of the test.
#![cfg(feature = "embedded")]

#[path = "../common/mod.rs"]
mod common;

mod resume;
mod service;
