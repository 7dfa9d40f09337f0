//! The metrics by name: buckets, texts and units. Names carry the prefix
//! `signorini_`, base units and `_total` for counters; every histogram has buckets,
//! because one without would be exported as a summary.

use metrics::{Recorder, Unit};
use metrics_exporter_prometheus::PrometheusRecorder;

pub(super) const BUILD_INFO: &str = "signorini_build_info";
pub(super) const ITERATIONS: &str = "signorini_iterations_total";
pub(super) const INCREMENTS: &str = "signorini_increments_total";
pub(super) const STEPS: &str = "signorini_steps_total";
pub(super) const FAILURES: &str = "signorini_failures_total";
pub(super) const FALLBACKS: &str = "signorini_fallbacks_total";
pub(super) const WARNINGS: &str = "signorini_warnings_total";
pub(super) const CUT_BACKS: &str = "signorini_cut_backs_total";
pub(super) const FACTORISATIONS: &str = "signorini_factorisations_total";
pub(super) const SOLVE_SECONDS: &str = "signorini_solve_seconds";
pub(super) const PHASE_SECONDS: &str = "signorini_phase_seconds";
pub(super) const SQP_ITERATIONS: &str = "signorini_sqp_iterations";
pub(super) const KRYLOV_ITERATIONS: &str = "signorini_krylov_iterations";
pub(super) const APPLICATIONS: &str = "signorini_preconditioner_applications";
pub(super) const SET_CHANGES: &str = "signorini_active_set_changes";
pub(super) const NEWTON_STEPS: &str = "signorini_friction_newton_steps";
pub(super) const THRESHOLD_PASSES: &str = "signorini_friction_threshold_passes";
pub(super) const CONTACT_VERTICES: &str = "signorini_contact_vertices";
pub(super) const CACHE_HITS: &str = "signorini_cache_hits_total";
pub(super) const CACHE_MISSES: &str = "signorini_cache_misses_total";
pub(super) const CACHE_EVICTIONS: &str = "signorini_cache_evictions_total";
pub(super) const SESSIONS: &str = "signorini_sessions";
pub(super) const STREAMS: &str = "signorini_streams";
pub(super) const MESHES: &str = "signorini_meshes";
pub(super) const PREPARED: &str = "signorini_prepared";
pub(super) const MEMORY: &str = "signorini_memory_bytes";
pub(super) const MEMORY_BUDGET: &str = "signorini_memory_budget_bytes";
pub(super) const QUEUE_DEPTH: &str = "signorini_queue_depth";
pub(super) const QUEUE_WAIT: &str = "signorini_queue_wait_seconds";
pub(super) const SLOTS_BUSY: &str = "signorini_slots_busy";
pub(super) const CANCEL_SECONDS: &str = "signorini_cancel_seconds";
pub(super) const REFUSED: &str = "signorini_refused_total";
pub(super) const LEFT_BEHIND: &str = "signorini_steps_left_behind_total";
pub(super) const COALESCED: &str = "signorini_iterations_coalesced_total";

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

pub(super) const HISTOGRAMS: [(&str, &[f64], &str); 11] = [
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
        NEWTON_STEPS,
        COUNTS,
        "Steps of Newton's method for friction in one increment with friction.",
    ),
    (
        THRESHOLD_PASSES,
        COUNTS,
        "Passes over the threshold of friction in one increment of that method.",
    ),
    (
        CONTACT_VERTICES,
        VERTICES,
        "Vertices in contact at the end of an increment.",
    ),
];

pub(super) const COUNTERS: [(&str, &str); 14] = [
    (ITERATIONS, "Krylov iterations of all sessions."),
    (INCREMENTS, "Finished increments by termination."),
    (STEPS, "Finished steps by termination."),
    (FAILURES, "Increments that did not converge, by cause."),
    (
        FALLBACKS,
        "Increments that a second attempt solved, by its rung.",
    ),
    (
        WARNINGS,
        "Warnings in the results of increments, by kind; `snapped` counts falls.",
    ),
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

pub(super) const GAUGES: [(&str, &str); 9] = [
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

/// Enters texts and units of all metrics.
pub(super) fn describe(recorder: &PrometheusRecorder) {
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
