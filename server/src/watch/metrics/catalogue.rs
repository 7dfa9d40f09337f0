//! The metrics by name: buckets, texts and units. Names carry the prefix
//! `signorini_`, base units and `_total` for counters; every histogram has buckets,
//! because one without would be exported as a summary.
//!
//! Calls are named as in go-grpc-middleware (`grpc_server_*`), so that its dashboards
//! fit; what the process itself uses (`process_*`) is named by the crate
//! `metrics-process`, as every Prometheus client does.

use metrics::{Recorder, Unit};
use metrics_exporter_prometheus::PrometheusRecorder;

pub(super) const BUILD_INFO: &str = "signorini_build_info";
pub(super) const ITERATIONS: &str = "signorini_iterations_total";
pub(super) const INCREMENTS: &str = "signorini_increments_total";
pub(super) const STEPS: &str = "signorini_steps_total";
pub(super) const FAILURES: &str = "signorini_failures_total";
pub(super) const WARNINGS: &str = "signorini_warnings_total";
pub(super) const LEAKS: &str = "signorini_leaks_total";
pub(super) const CUT_BACKS: &str = "signorini_cut_backs_total";
pub(super) const ATTEMPTS: &str = "signorini_attempts_total";
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
pub(super) const PAUSES: &str = "signorini_slot_pauses_total";
pub(super) const CONNECTIONS: &str = "signorini_connections";
pub(super) const TURNED_AWAY: &str = "signorini_connections_turned_away_total";
pub(super) const LINES_LEFT_OUT: &str = "signorini_log_lines_left_out_total";
pub(super) const FOLDER_GONE: &str = "signorini_data_folder_gone";
pub(super) const UNWRITABLE: &str = "signorini_data_unwritable";
pub(super) const DATA_FREE: &str = "signorini_data_free_bytes";
pub(super) const DATA_SIZE: &str = "signorini_data_size_bytes";
pub(super) const DECODING: &str = "signorini_decoding_bytes";
pub(super) const UPLOADS: &str = "signorini_uploads";
pub(super) const LEFT_BEHIND: &str = "signorini_steps_left_behind_total";
pub(super) const COALESCED: &str = "signorini_iterations_coalesced_total";
pub(super) const SLOTS: &str = "signorini_slots";
pub(super) const RESIDUAL: &str = "signorini_residual";
pub(super) const RECEIVED: &str = "signorini_received_bytes_total";
pub(super) const SENT: &str = "signorini_sent_bytes_total";
pub(super) const JOURNAL_COMMIT_SECONDS: &str = "signorini_journal_commit_seconds";
pub(super) const JOURNAL_BYTES: &str = "signorini_journal_bytes_total";
pub(super) const JOURNAL_FAILURES: &str = "signorini_journal_failures_total";
pub(super) const REPLAY_SECONDS: &str = "signorini_replay_seconds";
pub(super) const REPLAY_DIFFERENCES: &str = "signorini_replay_differences_total";
pub(super) const DAMAGED: &str = "signorini_damaged_total";
pub(super) const CERTIFICATE_EXPIRY: &str = "signorini_certificate_expiry_timestamp_seconds";
pub(super) const ASLEEP: &str = "signorini_sessions_asleep";
pub(super) const CALLS_STARTED: &str = "grpc_server_started_total";
pub(super) const CALLS_HANDLED: &str = "grpc_server_handled_total";
pub(super) const CALL_SECONDS: &str = "grpc_server_handling_seconds";

/// 1 ms to 1 h: steps of 1.6 up to 10 s, where most increments lie, so that a
/// quantile of steps of 6 ms is no guess.
const SECONDS: &[f64] = &[
    0.001, 0.0016, 0.0025, 0.004, 0.006, 0.01, 0.016, 0.025, 0.04, 0.06, 0.1, 0.16, 0.25, 0.4, 0.6,
    1.0, 1.6, 2.5, 4.0, 6.0, 10.0, 25.0, 60.0, 150.0, 400.0, 1000.0, 3600.0,
];
/// 1 ms to 1 h, coarser: there are as many of these as there are methods.
const WAITS: &[f64] = &[
    0.001, 0.0025, 0.006, 0.016, 0.04, 0.1, 0.25, 0.6, 1.5, 4.0, 10.0, 60.0, 600.0, 3600.0,
];
/// 1 to 64: what is counted in ones.
const FEW: &[f64] = &[
    1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 24.0, 32.0, 64.0,
];
/// 4 to 4096: what is counted in tens.
const MANY: &[f64] = &[
    4.0, 8.0, 12.0, 16.0, 20.0, 25.0, 32.0, 40.0, 50.0, 64.0, 80.0, 100.0, 128.0, 180.0, 256.0,
    400.0, 640.0, 1024.0, 2048.0, 4096.0,
];
const VERTICES: &[f64] = &[
    1.0, 4.0, 16.0, 64.0, 256.0, 1024.0, 4096.0, 16384.0, 65536.0,
];

pub(super) const HISTOGRAMS: [(&str, &[f64], &str); 14] = [
    (
        JOURNAL_COMMIT_SECONDS,
        WAITS,
        "Time of one commit of the journal: writing, and waiting for the disk.",
    ),
    (
        REPLAY_SECONDS,
        WAITS,
        "Time that a session from the journal took to get back to its state.",
    ),
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
        CALL_SECONDS,
        WAITS,
        "Time from a call to its last byte, by method and code; a stream lasts as long as it is open.",
    ),
    (
        QUEUE_WAIT,
        WAITS,
        "Time that a job waited for a solver slot.",
    ),
    (
        CANCEL_SECONDS,
        WAITS,
        "Time from a cancel request to the result of the step.",
    ),
    (SQP_ITERATIONS, FEW, "SQP iterations of one increment."),
    (
        KRYLOV_ITERATIONS,
        MANY,
        "Krylov iterations of one increment.",
    ),
    (
        APPLICATIONS,
        MANY,
        "Applications of the displacement preconditioner in one increment.",
    ),
    (
        SET_CHANGES,
        FEW,
        "Revisions of the active set in one increment.",
    ),
    (
        NEWTON_STEPS,
        FEW,
        "Steps of Newton's method for friction in one increment with friction.",
    ),
    (
        THRESHOLD_PASSES,
        FEW,
        "Passes over the threshold of friction in one increment of that method.",
    ),
    (
        CONTACT_VERTICES,
        VERTICES,
        "Vertices in contact at the end of an increment.",
    ),
];

pub(super) const COUNTERS: [(&str, &str); 26] = [
    (JOURNAL_BYTES, "Bytes handed to the journal."),
    (JOURNAL_FAILURES, "Writes that the disk refused."),
    (
        REPLAY_DIFFERENCES,
        "Results that a replay found otherwise than the first run.",
    ),
    (
        DAMAGED,
        "Readings of the data folder that found something not as it was written, by kind.",
    ),
    (ITERATIONS, "Krylov iterations of all sessions."),
    (INCREMENTS, "Finished increments by termination."),
    (STEPS, "Finished steps by termination."),
    (FAILURES, "Increments that did not converge, by cause."),
    (
        WARNINGS,
        "Warnings in the results of increments, by kind; `snapped` counts falls.",
    ),
    (
        LEAKS,
        "Fluids that were seen to leak in an increment, whether that was asked for or not.",
    ),
    (CUT_BACKS, "Cut-backs inside increments."),
    (
        ATTEMPTS,
        "Attempts inside increments that failed, by strategy and what followed.",
    ),
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
        "Steps answered whose solver thread had still not stopped 5 s later.",
    ),
    (
        PAUSES,
        "Times that a step gave its slot to a client that had less.",
    ),
    (
        TURNED_AWAY,
        "Connections closed because there were too many, they were silent, no descriptor was left, or a handshake failed; by reason.",
    ),
    (
        LINES_LEFT_OUT,
        "Refusals that the log left out because there were too many, by whose they were.",
    ),
    (RECEIVED, "Bytes of messages that clients sent."),
    (SENT, "Bytes of messages that clients were sent."),
    (CALLS_STARTED, "Calls begun, by method."),
    (CALLS_HANDLED, "Calls ended, by method and code."),
];

pub(super) const GAUGES: [(&str, &str); 20] = [
    (BUILD_INFO, "1; the labels name the build."),
    (SESSIONS, "Sessions that exist."),
    (
        ASLEEP,
        "Sessions that are in the data folder only until they are called.",
    ),
    (
        STREAMS,
        "Open `Solve` and `Watch` streams, those included that have named no session yet.",
    ),
    (
        CERTIFICATE_EXPIRY,
        "Unix time from which a certificate is good no more, by its use.",
    ),
    (
        FOLDER_GONE,
        "1 while the data folder is not where the server found it, so that nothing is taken.",
    ),
    (
        UNWRITABLE,
        "1 while the newest write to the data folder was refused.",
    ),
    (
        DATA_FREE,
        "Bytes that are free on the disk of the data folder; 0 without one.",
    ),
    (
        DATA_SIZE,
        "Bytes of the disk of the data folder; 0 without one.",
    ),
    (CONNECTIONS, "Open connections."),
    (
        DECODING,
        "Bytes taken by messages of clients that are received, decoded and handled.",
    ),
    (UPLOADS, "Uploads of meshes under way."),
    (MESHES, "Meshes in the store."),
    (PREPARED, "Prepared data in the store."),
    (MEMORY, "Bytes held, by kind."),
    (MEMORY_BUDGET, "Bytes that may be held."),
    (QUEUE_DEPTH, "Jobs that wait for a solver slot."),
    (SLOTS_BUSY, "Solver slots at work."),
    (SLOTS, "Solver slots that there are."),
    (
        RESIDUAL,
        "Largest residual of the step that runs in a slot; 0 while none does.",
    ),
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
