//! The service as a client sees it: connections, uploads, sessions and their streams.
//!
//! | file | what it does |
//! |---|---|
//! | `connect`, `credentials` | connections to a server, and what each side shows the other |
//! | `error` | what can go wrong, typed by the reasons of the contract |
//! | `backoff`, `breaks` | pauses before a new attempt; what is tried again |
//! | `mesh`, `surface` | uploads, named by their digests |
//! | `refine` | meshes that the server refines |
//! | `session` | make, look at and delete sessions; plans |
//! | `solve` | the stream that drives a session |
//! | `read` | kept results |
//! | `result_line` | messages of the stream as lines of JSON |
//! | `bounded_file` | files that a user names, up to a limit |

mod backoff;
pub mod bounded_file;
mod breaks;
pub(crate) mod connect;
pub(crate) mod credentials;
pub(crate) mod error;
pub(crate) mod mesh;
pub(crate) mod read;
pub mod refine;
pub mod result_line;
pub(crate) mod session;
pub mod solve;
pub(crate) mod surface;
