//! What a worker tells Prometheus: cases by how they ended, those in work, seconds that the
//! solver took and seconds beside it. No name of a case or a study is a label.

use std::sync::Arc;
use std::time::{Duration, Instant};

use metrics::{Counter, Gauge, Histogram, Key, Label, Level, Metadata, Recorder, Unit};
use metrics_exporter_prometheus::{BuildError, Matcher, PrometheusBuilder, PrometheusRecorder};
use tokio::net::TcpListener;

use crate::studies::row::{CONVERGED, FAILED, REFUSED, Row};

const CASES: &str = "signorini_worker_cases_total";
const GIVEN_BACK: &str = "signorini_worker_given_back_total";
const IN_WORK: &str = "signorini_worker_cases_in_work";
const WAITING: &str = "signorini_worker_cases_waiting";
const SOLVE: &str = "signorini_worker_solve_seconds";
const OVERHEAD: &str = "signorini_worker_overhead_seconds";

/// 1 ms to 1 h.
const SECONDS: &[f64] = &[
    0.001, 0.0025, 0.006, 0.016, 0.04, 0.1, 0.25, 0.6, 1.5, 4.0, 10.0, 60.0, 600.0, 3600.0,
];
/// How often samples move into buckets.
const UPKEEP: Duration = Duration::from_secs(5);

const METADATA: Metadata<'static> = Metadata::new(module_path!(), Level::INFO, None);

/// The metrics of one worker.
pub(crate) struct Gauges {
    recorder: PrometheusRecorder,
}

impl Gauges {
    /// All of them, at zero.
    pub(crate) fn new() -> Result<Self, BuildError> {
        let mut builder = PrometheusBuilder::new();
        for name in [SOLVE, OVERHEAD] {
            builder = builder.set_buckets_for_metric(Matcher::Full(name.to_owned()), SECONDS)?;
        }
        let gauges = Self {
            recorder: builder.build_recorder(),
        };
        gauges.describe();
        for termination in [CONVERGED, "not_converged", REFUSED, FAILED] {
            gauges.ended(termination).increment(0);
        }
        gauges.counter(GIVEN_BACK, Vec::new()).increment(0);
        gauges.gauge(IN_WORK).set(0.0);
        gauges.gauge(WAITING).set(0.0);
        drop(gauges.histogram(SOLVE));
        drop(gauges.histogram(OVERHEAD));
        Ok(gauges)
    }

    fn describe(&self) {
        for (name, text) in [
            (CASES, "Cases whose row is published, by how they ended."),
            (GIVEN_BACK, "Cases given back to the queue without a row."),
        ] {
            self.recorder
                .describe_counter(name.into(), None, text.into());
        }
        for (name, text) in [
            (IN_WORK, "Cases that the worker has."),
            (
                WAITING,
                "Cases of all studies that waited in the queue when the last one came.",
            ),
        ] {
            self.recorder.describe_gauge(name.into(), None, text.into());
        }
        for (name, text) in [
            (SOLVE, "Time of the solver for one case."),
            (
                OVERHEAD,
                "Time from when a case came to when its row was published, less the solver's.",
            ),
        ] {
            let unit = Some(Unit::Seconds);
            self.recorder
                .describe_histogram(name.into(), unit, text.into());
        }
    }

    /// A case came; so many wait still.
    pub(super) fn came(&self, waiting: u64) {
        self.gauge(IN_WORK).increment(1.0);
        self.gauge(WAITING).set(waiting as f64);
    }

    /// No case waits.
    pub(super) fn idle(&self) {
        self.gauge(WAITING).set(0.0);
    }

    /// The row of a case that came then is published.
    pub(super) fn done(&self, row: &Row, came: Instant) {
        self.ended(&row.termination).increment(1);
        self.histogram(SOLVE).record(row.seconds);
        let beside = (came.elapsed().as_secs_f64() - row.seconds).max(0.0);
        self.histogram(OVERHEAD).record(beside);
    }

    /// Another worker may have a case.
    pub(super) fn given_back(&self) {
        self.counter(GIVEN_BACK, Vec::new()).increment(1);
    }

    /// The worker has a case no more.
    pub(super) fn left(&self) {
        self.gauge(IN_WORK).decrement(1.0);
    }

    fn ended(&self, termination: &str) -> Counter {
        let label = Label::new("termination", termination.to_owned());
        self.counter(CASES, vec![label])
    }

    fn counter(&self, name: &'static str, labels: Vec<Label>) -> Counter {
        self.recorder
            .register_counter(&Key::from_parts(name, labels), &METADATA)
    }

    fn gauge(&self, name: &'static str) -> Gauge {
        self.recorder
            .register_gauge(&Key::from_static_name(name), &METADATA)
    }

    fn histogram(&self, name: &'static str) -> Histogram {
        self.recorder
            .register_histogram(&Key::from_static_name(name), &METADATA)
    }

    /// Shows them to whoever reaches the listener, until it is dropped.
    pub(crate) async fn serve(self: Arc<Self>, listener: TcpListener) {
        let handle = self.recorder.handle();
        let shown = handle.clone();
        let page = signorini_server::serve_metrics(listener, Arc::new(move || shown.render()));
        let upkeep = async {
            let mut ticks = tokio::time::interval(UPKEEP);
            loop {
                ticks.tick().await;
                handle.run_upkeep();
            }
        };
        tokio::join!(page, upkeep);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_counts_cases_by_how_they_ended_and_has_all_from_the_start() {
        let gauges = Gauges::new().unwrap();
        let page = gauges.recorder.handle().render();
        for line in [
            "signorini_worker_cases_total{termination=\"failed\"} 0",
            "signorini_worker_given_back_total 0",
            "signorini_worker_cases_in_work 0",
            "signorini_worker_cases_waiting 0",
        ] {
            assert!(page.contains(line), "{line}: {page}");
        }
        gauges.came(7);
        let mut row = Row::without(0, "0", CONVERGED);
        row.seconds = 0.02;
        gauges.done(&row, Instant::now());
        gauges.left();
        let page = gauges.recorder.handle().render();
        for line in [
            "signorini_worker_cases_total{termination=\"converged\"} 1",
            "signorini_worker_cases_in_work 0",
            "signorini_worker_cases_waiting 7",
            "signorini_worker_solve_seconds_bucket{le=\"0.04\"} 1",
            "signorini_worker_overhead_seconds_sum 0",
        ] {
            assert!(page.contains(line), "{line}: {page}");
        }
    }
}
