//! Streams between clients and sessions: `Solve` writes and reads, `Watch` only
//! reads. Both attach to a session's actor and empty their outbox by one pump. `RefineMesh` tells
//! of meshes.

mod pump;
mod refine;
mod solve;
mod watch;

pub(crate) use refine::open as open_refine;
pub(crate) use solve::{Call, open as open_solve};
pub(crate) use watch::open as open_watch;
