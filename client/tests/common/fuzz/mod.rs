//! Seeded campaigns of hostile inputs, each held to a budget of memory.

pub(crate) mod engine;
pub(crate) mod memory;

pub(crate) use engine::{Campaign, Corpus, Form};
