//! Every metric of the server, the only place that names one: what is counted here,
//! names, buckets and texts in `catalogue`.
//!
//! Labels come from small fixed sets; sessions and meshes are never labels.
//! Metrics live in a recorder of this server, not of the process, so that
//! several servers in one process do not mix. Every label has its series from the
//! start (`start`): the first failure would be no increase otherwise.

mod away;
mod calls;
mod catalogue;
#[cfg(feature = "fleet")]
mod fleet;
mod start;

use std::sync::Arc;
use std::time::{Duration, Instant};

use metrics::{Counter, Gauge, Histogram, Key, Label, Level, Metadata, Recorder};
use metrics_exporter_prometheus::{
    BuildError, Matcher, PrometheusBuilder, PrometheusHandle, PrometheusRecorder,
};
use signorini::report::{Seconds, StepReport, Strategy, Termination, Tightness};

pub(crate) use calls::{CallKind, Method, OpenCall};
use catalogue::*;
pub(crate) use start::COMMIT;

use crate::fault::status;
use crate::watch::lines::{LineBudget, Whose};

pub(crate) use away::Away;

/// The cause of the contract that no solver gives.
const SERVER_TIME_LIMIT: &str = "server_time_limit";

/// What a cache of the store holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Mesh,
    Prepared,
    Session,
}

impl Kind {
    const ALL: [Self; 3] = [Self::Mesh, Self::Prepared, Self::Session];

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
    /// What the process itself uses.
    process: metrics_process::Collector,
    iterations: Counter,
    received: Counter,
    sent: Counter,
    /// Of strangers and of clients.
    lines: [LineBudget; 2],
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
        let count = |name| recorder.register_counter(&Key::from_static_name(name), &METADATA);
        let metrics = Self {
            handle: recorder.handle(),
            process: metrics_process::Collector::default(),
            iterations: count(ITERATIONS),
            received: count(RECEIVED),
            sent: count(SENT),
            lines: Whose::ALL.map(LineBudget::new),
            recorder,
        };
        metrics.show_from_the_start(&status::REASONS);
        Ok(Arc::new(metrics))
    }

    /// The page that Prometheus reads.
    pub(crate) fn render(&self) -> String {
        metrics::with_local_recorder(&self.recorder, || self.process.collect());
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
        for warning in &report.warnings {
            self.counter(WARNINGS, &[("kind", warning.kind.name())])
                .increment(1);
        }
        for fluid in report.fluids.values() {
            let leaks = fluid.tightness == Tightness::Leaks;
            self.counter(LEAKS, &[]).increment(leaks.into());
        }
        self.counter(CUT_BACKS, &[])
            .increment(report.cut_backs.into());
        for attempt in &report.attempts {
            self.attempts(attempt.strategy, attempt.followed_by)
                .increment(1);
        }
        self.counter(FACTORISATIONS, &[])
            .increment(report.factorisations.into());
        for (phase, value) in phases(&report.seconds) {
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
        for (name, count) in [
            (NEWTON_STEPS, report.newton_steps),
            (THRESHOLD_PASSES, report.threshold_passes),
        ] {
            // A body without friction has neither, which is no count of zero.
            if count > 0 {
                self.histogram(name, &[]).record(f64::from(count));
            }
        }
    }

    /// Attempts with `strategy` that failed, by what followed.
    fn attempts(&self, strategy: Strategy, followed_by: Option<Strategy>) -> Counter {
        let next = followed_by.map_or("end", Strategy::name);
        let labels = [("strategy", strategy.name()), ("followed_by", next)];
        self.counter(ATTEMPTS, &labels)
    }

    /// An increment reached the ceiling of its step's time.
    pub(crate) fn server_time_limit(&self) {
        self.counter(FAILURES, &[("cause", SERVER_TIME_LIMIT)])
            .increment(1);
    }

    /// One commit of the journal.
    pub(crate) fn journal_commit(&self, time: Duration, bytes: usize) {
        self.histogram(JOURNAL_COMMIT_SECONDS, &[])
            .record(time.as_secs_f64());
        self.counter(JOURNAL_BYTES, &[]).increment(bytes as u64);
    }

    /// A write that the disk refused.
    pub(crate) fn journal_failed(&self) {
        self.counter(JOURNAL_FAILURES, &[]).increment(1);
    }

    /// When a certificate ends, Unix seconds.
    pub(crate) fn certificate_expiry(&self, certificate: &'static str, end: i64) {
        self.gauge(CERTIFICATE_EXPIRY, &[("certificate", certificate)])
            .set(end as f64);
    }

    /// Something of the data folder is not as it was written, by what it is.
    pub(crate) fn damaged(&self, kind: &'static str) {
        self.counter(DAMAGED, &[("kind", kind)]).increment(1);
    }

    /// A session is back at its state.
    pub(crate) fn replay(&self, seconds: f64) {
        self.histogram(REPLAY_SECONDS, &[]).record(seconds);
    }

    /// Results that a replay found otherwise than the journal has them.
    pub(crate) fn replay_differences(&self, count: usize) {
        self.counter(REPLAY_DIFFERENCES, &[])
            .increment(count as u64);
    }

    /// Sessions that only the data folder has.
    pub(crate) fn asleep(&self, count: usize) {
        self.gauge(ASLEEP, &[]).set(count as f64);
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

    /// Whether the log may take one more line about refusals; counted if not.
    pub(crate) fn may_tell_of(&self, whose: Whose) -> bool {
        let [strangers, clients] = &self.lines;
        let budget = match whose {
            Whose::Strangers => strangers,
            Whose::Clients => clients,
        };
        let may = budget.take(Instant::now());
        if !may {
            self.lines_left_out(whose).increment(1);
        }
        may
    }

    /// Says how many lines the log has left out of late; call now and then.
    pub(crate) fn tell_lines_left_out(&self) {
        for (whose, budget) in Whose::ALL.iter().zip(&self.lines) {
            let lines = budget.left_out();
            if lines > 0 {
                let whose = whose.name();
                tracing::warn!(lines, whose, "refusals left out of the log");
            }
        }
    }

    fn lines_left_out(&self, whose: Whose) -> Counter {
        self.counter(LINES_LEFT_OUT, &[("whose", whose.name())])
    }

    pub(crate) fn coalesced(&self, count: u64) {
        self.counter(COALESCED, &[]).increment(count);
    }

    /// A step was answered without its solver thread, which does not stop.
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

    /// A job gave its slot away.
    pub(crate) fn paused(&self) {
        self.counter(PAUSES, &[]).increment(1);
        self.gauge(SLOTS_BUSY, &[]).decrement(1.0);
    }

    pub(crate) fn resumed(&self) {
        self.gauge(SLOTS_BUSY, &[]).increment(1.0);
    }

    pub(crate) fn connections(&self, count: usize) {
        self.set(CONNECTIONS, count);
    }

    pub(crate) fn turned_away(&self, why: &'static str) {
        self.turned_away_by(why).increment(1);
    }

    fn turned_away_by(&self, why: &'static str) -> Counter {
        self.counter(TURNED_AWAY, &[("reason", why)])
    }

    pub(crate) fn decoding(&self, bytes: usize) {
        self.set(DECODING, bytes);
    }

    pub(crate) fn data_folder_gone(&self, is_gone: bool) {
        self.set(FOLDER_GONE, usize::from(is_gone));
    }

    pub(crate) fn data_unwritable(&self, is_refused: bool) {
        self.set(UNWRITABLE, usize::from(is_refused));
    }

    /// Bytes of the disk of the data folder: free ones, and all.
    pub(crate) fn data_room(&self, free: u64, size: u64) {
        self.gauge(DATA_FREE, &[]).set(free as f64);
        self.gauge(DATA_SIZE, &[]).set(size as f64);
    }

    pub(crate) fn uploads(&self, count: usize) {
        self.set(UPLOADS, count);
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

    /// Solver slots that there are.
    pub(crate) fn slots(&self, count: usize) {
        self.set(SLOTS, count);
    }

    /// Where a slot shows the residual of what it runs.
    pub(crate) fn residual(&self, slot: usize) -> Gauge {
        let labels = vec![Label::new("slot", slot.to_string())];
        let gauge = self
            .recorder
            .register_gauge(&Key::from_parts(RESIDUAL, labels), &METADATA);
        gauge.set(0.0);
        gauge
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

/// The phases of an increment with their seconds.
fn phases(seconds: &Seconds) -> [(&'static str, f64); 6] {
    [
        ("prepare", seconds.prepare),
        ("assemble", seconds.assemble),
        ("factorise", seconds.factorise),
        ("krylov", seconds.krylov),
        ("contact", seconds.contact),
        ("stability", seconds.stability),
    ]
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

#[cfg(test)]
mod tests;
