//! The series that exist before anything happened: every label of every metric.
//!
//! A counter that appears with its first event has no increase there, so the first
//! failure would be lost to alerts; a panel of a series that is missing says "no data".

use signorini::assembly::simd::InstructionSet;
use signorini::report::{Cause, Seconds, Strategy, Termination, WarningKind};

use super::catalogue::*;
use super::{Away, Kind, Metrics, SERVER_TIME_LIMIT, phases};
use crate::watch::lines::Whose;

/// The commit that the program was built from; `unknown` outside release builds.
pub(crate) const COMMIT: &str = env!("SIGNORINI_COMMIT");

impl Metrics {
    /// Makes all series of fixed labels; `reasons` are those of refusals.
    pub(super) fn show_from_the_start(&self, reasons: &[&'static str]) {
        self.process_metrics();
        self.gauges();
        self.outcomes();
        self.caches();
        for name in [
            LEAKS,
            CUT_BACKS,
            FACTORISATIONS,
            COALESCED,
            LEFT_BEHIND,
            PAUSES,
            RECEIVED,
            SENT,
            JOURNAL_BYTES,
            JOURNAL_FAILURES,
            REPLAY_DIFFERENCES,
        ] {
            self.counter(name, &[]).increment(0);
        }
        for reason in reasons {
            self.counter(REFUSED, &[("reason", reason)]).increment(0);
        }
        for kind in ["session", "mesh", "surface", "state"] {
            self.counter(DAMAGED, &[("kind", kind)]).increment(0);
        }
        for why in Away::ALL {
            self.turned_away_by(why.name()).increment(0);
        }
        for whose in Whose::ALL {
            self.lines_left_out(whose).increment(0);
        }
        for name in [
            QUEUE_WAIT,
            CANCEL_SECONDS,
            JOURNAL_COMMIT_SECONDS,
            REPLAY_SECONDS,
            SQP_ITERATIONS,
            KRYLOV_ITERATIONS,
            APPLICATIONS,
            SET_CHANGES,
            NEWTON_STEPS,
            THRESHOLD_PASSES,
            CONTACT_VERTICES,
        ] {
            self.show_histogram(name, &[]);
        }
    }

    fn process_metrics(&self) {
        metrics::with_local_recorder(&self.recorder, || self.process.describe());
    }

    fn gauges(&self) {
        let build = [
            ("version", env!("CARGO_PKG_VERSION")),
            ("commit", COMMIT),
            ("instruction_set", InstructionSet::of_this_machine().name()),
        ];
        self.gauge(BUILD_INFO, &build).set(1.0);
        for (name, _) in GAUGES {
            if ![BUILD_INFO, MEMORY, RESIDUAL, CERTIFICATE_EXPIRY].contains(&name) {
                self.gauge(name, &[]).set(0.0);
            }
        }
        for kind in Kind::ALL {
            self.memory(kind, 0);
        }
    }

    /// How steps and increments end, and what is said of them.
    fn outcomes(&self) {
        for termination in Termination::ALL {
            let label = [("termination", termination.name())];
            self.counter(STEPS, &label).increment(0);
            self.counter(INCREMENTS, &label).increment(0);
            self.show_histogram(SOLVE_SECONDS, &label);
        }
        let causes = Cause::ALL.map(Cause::name).into_iter();
        for cause in causes.chain([SERVER_TIME_LIMIT]) {
            self.counter(FAILURES, &[("cause", cause)]).increment(0);
        }
        for kind in WarningKind::ALL {
            self.counter(WARNINGS, &[("kind", kind.name())])
                .increment(0);
        }
        for strategy in Strategy::ALL {
            for next in Strategy::ALL {
                self.attempts(strategy, Some(next)).increment(0);
            }
            self.attempts(strategy, None).increment(0);
        }
        for (phase, _) in phases(&Seconds::default()) {
            self.show_histogram(PHASE_SECONDS, &[("phase", phase)]);
        }
    }

    fn show_histogram(&self, name: &'static str, labels: &[(&'static str, &'static str)]) {
        // Registered is enough: the page shows it with no samples.
        drop(self.histogram(name, labels));
    }

    fn caches(&self) {
        for kind in [Kind::Mesh, Kind::Prepared] {
            for name in [CACHE_HITS, CACHE_MISSES, CACHE_EVICTIONS] {
                self.counter(name, &[("kind", kind.name())]).increment(0);
            }
        }
    }
}
