//! Every metric of the server: names, labels, buckets and texts, the only place.
//!
//! Names carry the prefix `signorini_`, base units and `_total` for counters.
//! Labels come from small fixed sets; sessions and meshes are never labels.
//! Metrics live in a recorder of this server, not of the process, so that
//! several servers in one process do not mix. Every histogram has buckets,
//! because one without would be exported as a summary.

use std::sync::Arc;
use std::time::Duration;

use metrics::{Counter, Gauge, Histogram, Key, Label, Level, Metadata, Recorder, Unit};
use metrics_exporter_prometheus::{
    BuildError, Matcher, PrometheusBuilder, PrometheusHandle, PrometheusRecorder,
};
use signorini::report::{Cause, StepReport, Termination};

const BUILD_INFO: &str = "signorini_build_info";
const ITERATIONS: &str = "signorini_iterations_total";
const INCREMENTS: &str = "signorini_increments_total";
const STEPS: &str = "signorini_steps_total";
const FAILURES: &str = "signorini_failures_total";
const CUT_BACKS: &str = "signorini_cut_backs_total";
const FACTORISATIONS: &str = "signorini_factorisations_total";
const SOLVE_SECONDS: &str = "signorini_solve_seconds";
const PHASE_SECONDS: &str = "signorini_phase_seconds";
const SQP_ITERATIONS: &str = "signorini_sqp_iterations";
const KRYLOV_ITERATIONS: &str = "signorini_krylov_iterations";
const APPLICATIONS: &str = "signorini_preconditioner_applications";
const SET_CHANGES: &str = "signorini_active_set_changes";
const CONTACT_VERTICES: &str = "signorini_contact_vertices";
const CACHE_HITS: &str = "signorini_cache_hits_total";
const CACHE_MISSES: &str = "signorini_cache_misses_total";
const CACHE_EVICTIONS: &str = "signorini_cache_evictions_total";
const SESSIONS: &str = "signorini_sessions";
const STREAMS: &str = "signorini_streams";
const MESHES: &str = "signorini_meshes";
const PREPARED: &str = "signorini_prepared";
const MEMORY: &str = "signorini_memory_bytes";
const MEMORY_BUDGET: &str = "signorini_memory_budget_bytes";
const QUEUE_DEPTH: &str = "signorini_queue_depth";
const QUEUE_WAIT: &str = "signorini_queue_wait_seconds";
const SLOTS_BUSY: &str = "signorini_slots_busy";
const CANCEL_SECONDS: &str = "signorini_cancel_seconds";
const REFUSED: &str = "signorini_refused_total";
const LEFT_BEHIND: &str = "signorini_steps_left_behind_total";
const COALESCED: &str = "signorini_iterations_coalesced_total";

/// 1 ms to 1 h.
const SECONDS: &[f64] = &[
    0.001, 0.0025, 0.006, 0.016, 0.04, 0.1, 0.25, 0.6, 1.5, 4.0, 10.0, 25.0, 60.0, 150.0, 400.0,
    1000.0, 3600.0,
];
/// 1 to 2048.
const COUNTS: &[f64] = &[
    1.0, 2.0, 4.0, 8.0, 12.0, 16.0, 24.0, 32.0, 64.0, 128.0, 256.0, 512.0, 1024.0, 2048.0,
];
const VERTICES: &[f64] = &[
    1.0, 4.0, 16.0, 64.0, 256.0, 1024.0, 4096.0, 16384.0, 65536.0,
];

const HISTOGRAMS: [(&str, &[f64], &str); 9] = [
    (
        SOLVE_SECONDS,
        SECONDS,
        "Wall time of one increment, preparation of the first included.",
    ),
    (
        PHASE_SECONDS,
        SECONDS,
        "Wall time of one increment by phase.",
    ),
    (
        QUEUE_WAIT,
        SECONDS,
        "Time that a job waited for a solver slot.",
    ),
    (
        CANCEL_SECONDS,
        SECONDS,
        "Time from a cancel request to the result of the step.",
    ),
    (SQP_ITERATIONS, COUNTS, "SQP iterations of one increment."),
    (
        KRYLOV_ITERATIONS,
        COUNTS,
        "Krylov iterations of one increment.",
    ),
    (
        APPLICATIONS,
        COUNTS,
        "Applications of the displacement preconditioner in one increment.",
    ),
    (
        SET_CHANGES,
        COUNTS,
        "Revisions of the active set in one increment.",
    ),
    (
        CONTACT_VERTICES,
        VERTICES,
        "Vertices in contact at the end of an increment.",
    ),
];

const COUNTERS: [(&str, &str); 12] = [
    (ITERATIONS, "Krylov iterations of all sessions."),
    (INCREMENTS, "Finished increments by termination."),
    (STEPS, "Finished steps by termination."),
    (FAILURES, "Increments that did not converge, by cause."),
    (CUT_BACKS, "Cut-backs inside increments."),
    (FACTORISATIONS, "Factorisations of the P1 block."),
    (CACHE_HITS, "Meshes and prepared data found in the store."),
    (
        CACHE_MISSES,
        "Meshes and prepared data that were not in the store.",
    ),
    (
        CACHE_EVICTIONS,
        "Meshes and prepared data dropped to make room.",
    ),
    (REFUSED, "Refused requests and updates by reason."),
    (
        COALESCED,
        "Iteration messages that a slow reader did not get.",
    ),
    (
        LEFT_BEHIND,
        "Steps answered while their solver thread could not stop.",
    ),
];

const GAUGES: [(&str, &str); 9] = [
    (BUILD_INFO, "1; the labels name the build."),
    (SESSIONS, "Sessions that exist."),
    (STREAMS, "Open solve streams."),
    (MESHES, "Meshes in the store."),
    (PREPARED, "Prepared data in the store."),
    (MEMORY, "Bytes held, by kind."),
    (MEMORY_BUDGET, "Bytes that may be held."),
    (QUEUE_DEPTH, "Jobs that wait for a solver slot."),
    (SLOTS_BUSY, "Solver slots at work."),
];

/// What a cache of the store holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Mesh,
    Prepared,
    Session,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Mesh => "mesh",
            Self::Prepared => "prepared",
            Self::Session => "session",
        }
    }
}

/// The metrics of one server.
pub(crate) struct Metrics {
    recorder: PrometheusRecorder,
    handle: PrometheusHandle,
    iterations: Counter,
}

impl Metrics {
    /// Empty metrics with all texts and buckets set.
    ///
    /// # Errors
    /// When the exporter refuses a bucket list.
    pub(crate) fn new() -> Result<Arc<Self>, BuildError> {
        let mut builder = PrometheusBuilder::new();
        for (name, buckets, _) in HISTOGRAMS {
            builder = builder.set_buckets_for_metric(Matcher::Full(name.to_owned()), buckets)?;
        }
        let recorder = builder.build_recorder();
        describe(&recorder);
        let metrics = Self {
            handle: recorder.handle(),
            iterations: recorder.register_counter(&Key::from_static_name(ITERATIONS), &METADATA),
            recorder,
        };
        metrics.show_from_the_start();
        Ok(Arc::new(metrics))
    }

    /// The page that Prometheus reads.
    pub(crate) fn render(&self) -> String {
        self.handle.render()
    }

    /// Moves recorded samples into buckets; call now and then.
    pub(crate) fn upkeep(&self) {
        self.handle.run_upkeep();
    }

    pub(crate) fn iteration(&self) {
        self.iterations.increment(1);
    }

    /// One finished increment.
    pub(crate) fn increment(&self, report: &StepReport) {
        let termination = report.termination.name();
        self.counter(INCREMENTS, &[("termination", termination)])
            .increment(1);
        self.histogram(SOLVE_SECONDS, &[("termination", termination)])
            .record(report.seconds.total);
        if let Some(cause) = report.cause {
            self.counter(FAILURES, &[("cause", cause.name())])
                .increment(1);
        }
        self.counter(CUT_BACKS, &[])
            .increment(report.cut_backs.into());
        self.counter(FACTORISATIONS, &[])
            .increment(report.factorisations.into());
        let seconds = &report.seconds;
        for (phase, value) in [
            ("prepare", seconds.prepare),
            ("assemble", seconds.assemble),
            ("factorise", seconds.factorise),
            ("krylov", seconds.krylov),
            ("contact", seconds.contact),
        ] {
            self.histogram(PHASE_SECONDS, &[("phase", phase)])
                .record(value);
        }
        for (name, count) in [
            (SQP_ITERATIONS, report.sqp_iterations),
            (KRYLOV_ITERATIONS, report.krylov_iterations),
            (APPLICATIONS, report.preconditioner_applications),
            (SET_CHANGES, report.active_set_changes),
            (CONTACT_VERTICES, report.active_vertices),
        ] {
            self.histogram(name, &[]).record(f64::from(count));
        }
    }

    /// One finished step.
    pub(crate) fn step(&self, termination: Termination) {
        self.counter(STEPS, &[("termination", termination.name())])
            .increment(1);
    }

    pub(crate) fn cancelled(&self, after: Duration) {
        self.histogram(CANCEL_SECONDS, &[]).record(after);
    }

    pub(crate) fn cache_hit(&self, kind: Kind) {
        self.counter(CACHE_HITS, &[("kind", kind.name())])
            .increment(1);
    }

    pub(crate) fn cache_miss(&self, kind: Kind) {
        self.counter(CACHE_MISSES, &[("kind", kind.name())])
            .increment(1);
    }

    pub(crate) fn evicted(&self, kind: Kind) {
        self.counter(CACHE_EVICTIONS, &[("kind", kind.name())])
            .increment(1);
    }

    pub(crate) fn refused(&self, reason: &'static str) {
        self.counter(REFUSED, &[("reason", reason)]).increment(1);
    }

    pub(crate) fn coalesced(&self, count: u64) {
        self.counter(COALESCED, &[]).increment(count);
    }

    /// A step was answered without its solver thread.
    pub(crate) fn left_behind(&self) {
        self.counter(LEFT_BEHIND, &[]).increment(1);
    }

    pub(crate) fn queue_depth(&self, waiting: usize) {
        self.set(QUEUE_DEPTH, waiting);
    }

    pub(crate) fn job_started(&self, waited: Duration) {
        self.histogram(QUEUE_WAIT, &[]).record(waited);
        self.gauge(SLOTS_BUSY, &[]).increment(1.0);
    }

    pub(crate) fn job_ended(&self) {
        self.gauge(SLOTS_BUSY, &[]).decrement(1.0);
    }

    pub(crate) fn sessions(&self, count: usize) {
        self.set(SESSIONS, count);
    }

    pub(crate) fn stream_opened(&self) {
        self.gauge(STREAMS, &[]).increment(1.0);
    }

    pub(crate) fn stream_closed(&self) {
        self.gauge(STREAMS, &[]).decrement(1.0);
    }

    /// What the store holds.
    pub(crate) fn store(&self, meshes: usize, prepared: usize) {
        self.set(MESHES, meshes);
        self.set(PREPARED, prepared);
    }

    pub(crate) fn memory(&self, kind: Kind, bytes: u64) {
        self.gauge(MEMORY, &[("kind", kind.name())])
            .set(bytes as f64);
    }

    pub(crate) fn memory_budget(&self, bytes: u64) {
        self.gauge(MEMORY_BUDGET, &[]).set(bytes as f64);
    }

    /// Series that dashboards and alerts ask for before anything happened.
    fn show_from_the_start(&self) {
        let version = [("version", env!("CARGO_PKG_VERSION"))];
        self.gauge(BUILD_INFO, &version).set(1.0);
        for (name, _) in GAUGES {
            if ![BUILD_INFO, MEMORY].contains(&name) {
                self.gauge(name, &[]).set(0.0);
            }
        }
        for name in [CUT_BACKS, FACTORISATIONS, COALESCED, LEFT_BEHIND] {
            self.counter(name, &[]).increment(0);
        }
        for termination in [Termination::Converged, Termination::NotConverged] {
            self.counter(STEPS, &[("termination", termination.name())])
                .increment(0);
        }
        self.counter(FAILURES, &[("cause", Cause::Stagnation.name())])
            .increment(0);
        for kind in [Kind::Mesh, Kind::Prepared] {
            for name in [CACHE_HITS, CACHE_MISSES, CACHE_EVICTIONS] {
                self.counter(name, &[("kind", kind.name())]).increment(0);
            }
        }
    }

    fn set(&self, name: &'static str, value: usize) {
        self.gauge(name, &[]).set(value as f64);
    }

    fn counter(&self, name: &'static str, labels: &[(&'static str, &'static str)]) -> Counter {
        self.recorder
            .register_counter(&key(name, labels), &METADATA)
    }

    fn gauge(&self, name: &'static str, labels: &[(&'static str, &'static str)]) -> Gauge {
        self.recorder.register_gauge(&key(name, labels), &METADATA)
    }

    fn histogram(&self, name: &'static str, labels: &[(&'static str, &'static str)]) -> Histogram {
        self.recorder
            .register_histogram(&key(name, labels), &METADATA)
    }
}

const METADATA: Metadata<'static> =
    Metadata::new(module_path!(), Level::INFO, Some(module_path!()));

fn key(name: &'static str, labels: &[(&'static str, &'static str)]) -> Key {
    let labels: Vec<Label> = labels
        .iter()
        .map(|(key, value)| Label::from_static_parts(key, value))
        .collect();
    Key::from_parts(name, labels)
}

fn describe(recorder: &PrometheusRecorder) {
    for (name, _, text) in HISTOGRAMS {
        recorder.describe_histogram(name.into(), unit(name), text.into());
    }
    for (name, text) in COUNTERS {
        recorder.describe_counter(name.into(), None, text.into());
    }
    for (name, text) in GAUGES {
        recorder.describe_gauge(name.into(), unit(name), text.into());
    }
}

fn unit(name: &str) -> Option<Unit> {
    if name.ends_with("_seconds") {
        return Some(Unit::Seconds);
    }
    name.ends_with("_bytes").then_some(Unit::Bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::blank::report;

    fn filled() -> Arc<Metrics> {
        let metrics = Metrics::new().unwrap();
        metrics.increment(&report(1, 1, Termination::Converged));
        metrics.step(Termination::Converged);
        metrics.cancelled(Duration::from_millis(1));
        metrics.job_started(Duration::from_millis(1));
        metrics.refused("QUEUE_FULL");
        metrics.memory(Kind::Mesh, 1);
        metrics.increment(&StepReport {
            cause: Some(Cause::Stagnation),
            ..report(1, 2, Termination::NotConverged)
        });
        metrics.iteration();
        metrics
    }

    #[test]
    fn every_histogram_has_buckets_and_every_metric_a_text() {
        let page = filled().render();
        assert!(!page.contains(" summary"), "{page}");
        for (name, ..) in HISTOGRAMS {
            assert!(page.contains(&format!("# TYPE {name} histogram")), "{name}");
        }
        for (name, _) in COUNTERS {
            assert!(page.contains(&format!("# TYPE {name} counter")), "{name}");
            assert!(name.ends_with("_total"));
        }
        for (name, _) in GAUGES {
            assert!(page.contains(&format!("# TYPE {name} gauge")), "{name}");
        }
        let texts = page
            .lines()
            .filter(|line| line.starts_with("# HELP"))
            .count();
        assert_eq!(texts, HISTOGRAMS.len() + COUNTERS.len() + GAUGES.len());
    }

    #[test]
    fn two_servers_of_one_process_do_not_mix() {
        let (first, second) = (filled(), Metrics::new().unwrap());
        assert!(first.render().contains("signorini_iterations_total 1"));
        assert!(second.render().contains("signorini_iterations_total 0"));
    }
}
