//! What the operating system gives this process and tells it. Knows no other room.
//!
//! | file | what it does |
//! |---|---|
//! | `limits` | memory and descriptors of the process; the size of a message |
//! | `memory` | whether the system still gives memory; gives freed memory back |
//! | `large_pages` | an allocator that asks for large pages for large buffers |
//! | `users` | whether the users of the machine are told apart |
//! | `hangup` | SIGHUP, heard by all that read their files again |

pub(crate) mod hangup;
pub(crate) mod large_pages;
pub(crate) mod limits;
pub(crate) mod memory;
pub(crate) mod users;
