//! A refused request: counted by its reason, and said in the log.

use crate::fault::{Fault, status};
use crate::watch::metrics::Metrics;

/// Counts and logs the refusal of a request.
pub(crate) fn record(metrics: &Metrics, fault: &Fault) {
    let reason = status::reason(fault);
    metrics.refused(reason);
    tracing::info!(reason, why = status::text(fault), "request refused");
}
