//! The library's algebra with the samples of its tests.

pub(crate) use signorini::linalg::*;

#[allow(dead_code)]
#[path = "../../../../src/linalg/samples.rs"]
pub(crate) mod samples;
