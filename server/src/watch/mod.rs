//! How an operator sees the server: metrics, their page, the log, traces, and a look at the
//! machine.
//!
//! | file | what it does |
//! |---|---|
//! | `metrics` | every metric, with its name, buckets and text |
//! | `lines` | how many lines of the log refusals may write |
//! | `page` | plain HTTP for Prometheus and probes |
//! | `live` | a page of what runs just now, for a browser |
//! | `log` | lines on stderr, for people or as JSON |
//! | `traces` | spans of solves for a collector of OpenTelemetry |
//! | `doctor` | processor, memory, descriptors, loopback, clock and disk |

pub(crate) mod doctor;
pub(crate) mod lines;
pub(crate) mod live;
pub(crate) mod log;
pub(crate) mod metrics;
pub(crate) mod page;
pub(crate) mod traces;
