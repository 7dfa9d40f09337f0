//! The client library against a server in the process of the test.
#![cfg(feature = "embedded")]

#[path = "../common/mod.rs"]
mod common;

mod gateway;
mod proxies;
mod resume;
mod service;
