//! Error against run time.
#![allow(dead_code, unused_imports, reason = "the command follows")]

pub(crate) mod chart;
