//! What settings leave to parts of the server, in the units of those parts.

/// The slots of a server.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slots {
    /// All, at least 1.
    pub(crate) count: usize,
    /// Those of them that take no long work, fewer than all.
    pub(crate) short: usize,
    /// Those that one client may have at one time, at least 1.
    pub(crate) of_client: usize,
    /// Threads of each.
    pub(crate) threads: usize,
}

/// What the data folder may keep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limit {
    /// Bytes of all results with their fields, and of all states.
    pub(crate) bytes: u64,
    /// Unix seconds before which a result or a state is too old.
    pub(crate) oldest: i64,
}
