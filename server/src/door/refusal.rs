//! A refused request: counted by its reason, and said in the log.

use crate::fault::{Fault, status};
use crate::watch::lines::Whose;
use crate::watch::metrics::Metrics;

/// Counts and logs the refusal of a request of a client.
pub(crate) fn record(metrics: &Metrics, fault: &Fault) {
    record_of(Whose::Clients, metrics, fault);
}

/// As [`record`], and whether the log took the line.
pub(crate) fn record_of(whose: Whose, metrics: &Metrics, fault: &Fault) -> bool {
    let reason = status::reason(fault);
    metrics.refused(reason);
    let is_told = metrics.may_tell_of(whose);
    if is_told {
        tracing::info!(reason, why = status::text(fault), "request refused");
    }
    is_told
}
