//! The library's programs with the samples of its tests.

pub(crate) use signorini::inequality::*;

#[allow(dead_code)]
#[path = "../../../../src/inequality/samples.rs"]
mod samples;
#[path = "tests.rs"]
mod tests;
