//! What is done with a whole data folder and with states that leave it: backups, checks, exported
//! states. The folder's own format is that of `journal`, which sessions write; this room lies
//! above sessions, because a check restores them.
//!
//! | file | what it does |
//! |---|---|
//! | `control` | backups, of a running server or of a folder that no server uses |
//! | `fsck` | whether a server can go on from a folder |
//! | `states` | exported states: the bytes that travel, and those that were imported |

pub(crate) mod control;
pub(crate) mod fsck;
pub(crate) mod states;
