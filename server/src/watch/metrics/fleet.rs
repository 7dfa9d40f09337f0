//! Metrics of a server in a fleet; a server alone has none of them.

use std::time::Duration;

use metrics::{Recorder, Unit};

use super::Metrics;

const HELD: &str = "signorini_fleet_leases";
const RENEWALS: &str = "signorini_fleet_renewals_total";
const TAKEN: &str = "signorini_fleet_takeovers_total";
const FENCED: &str = "signorini_fleet_fenced_total";
const SILENCES: &str = "signorini_fleet_silences_total";
const SILENT: &str = "signorini_fleet_silent_seconds_total";

const TEXTS: [(&str, &str); 5] = [
    (RENEWALS, "Leases renewed."),
    (
        TAKEN,
        "Sessions taken over from another server, or from none.",
    ),
    (
        FENCED,
        "Records refused because another server had written since.",
    ),
    (
        SILENCES,
        "Sessions given up because their lease was not renewed in time.",
    ),
    (
        SILENT,
        "Seconds since the last renewal of sessions given up, whole, in all.",
    ),
];

/// Names of all.
#[cfg(test)]
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    TEXTS.iter().map(|(name, _)| *name).chain([HELD])
}

impl Metrics {
    /// The server is in a fleet.
    pub(crate) fn fleet_joined(&self) {
        for (name, text) in TEXTS {
            self.recorder
                .describe_counter(name.into(), None, text.into());
            self.counter(name, &[]).increment(0);
        }
        let text = "Sessions of the fleet that this server holds.";
        self.recorder
            .describe_gauge(HELD.into(), None::<Unit>, text.into());
        self.fleet_held(0);
    }

    /// Sessions that this server holds.
    pub(crate) fn fleet_held(&self, count: usize) {
        self.gauge(HELD, &[]).set(count as f64);
    }

    /// A lease is renewed.
    pub(crate) fn fleet_renewed(&self) {
        self.counter(RENEWALS, &[]).increment(1);
    }

    /// A session is taken over.
    pub(crate) fn fleet_taken(&self) {
        self.counter(TAKEN, &[]).increment(1);
    }

    /// A record came after that of another server.
    pub(crate) fn fleet_fenced(&self) {
        self.counter(FENCED, &[]).increment(1);
    }

    /// A session is given up so long after the last renewal of its lease.
    pub(crate) fn fleet_silent(&self, age: Duration) {
        self.counter(SILENCES, &[]).increment(1);
        self.counter(SILENT, &[]).increment(age.as_secs());
    }
}
