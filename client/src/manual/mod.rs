//! The manual keeps up with the program: keys of scenes, fields of results, flags,
//! settings, exit codes, and every snippet. Links and names of tests are checked by
//! `tests/architecture`, metrics by the server.

#[cfg(all(feature = "bench", feature = "embedded"))]
mod commands;
mod keys;
mod page;
mod results;
