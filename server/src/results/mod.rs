//! Results on their way from a session to its readers: kept, queued and sliced.
//!
//! `kept` holds what readers may come for later, `iterations` the newest statistics
//! of a running step, `outbox` what waits for one stream, `readers` who has seen
//! what; `unfinished` makes the reports of increments that no solver finished. The
//! room knows neither sessions nor streams: the actor fills it, the pumps empty it.

pub(crate) mod iterations;
pub(crate) mod kept;
pub(crate) mod outbox;
pub(crate) mod readers;
pub(crate) mod unfinished;
