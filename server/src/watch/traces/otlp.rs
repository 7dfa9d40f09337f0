//! Spans to a collector, by OTLP over gRPC.
//!
//! A solver thread notes times while it iterates and makes spans between programs; a thread of
//! the exporter sends them. What the collector does not take in time is dropped.

use std::sync::Arc;
use std::time::{Duration, SystemTime};

use opentelemetry::trace::{Span as _, SpanBuilder, TraceContextExt as _, Tracer as _};
use opentelemetry::trace::{Status, TracerProvider as _};
use opentelemetry::{Context, KeyValue};
use opentelemetry_otlp::{SpanExporter, WithExportConfig as _};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::trace::{SdkTracer, SdkTracerProvider};
use signorini::report::{IterationRecord, StepReport, Termination};

/// How long the collector may take for a batch, and for the last one at the end.
const PATIENCE: Duration = Duration::from_secs(2);

/// Traces of a server.
pub(crate) struct Traces(Option<SdkTracerProvider>);

impl Traces {
    /// Sends to the collector at `endpoint`, nothing where that is empty; inside a runtime.
    ///
    /// # Errors
    /// What is wrong with the endpoint.
    pub(crate) fn start(endpoint: &str) -> Result<Self, String> {
        if endpoint.is_empty() {
            return Ok(Self(None));
        }
        let exporter = SpanExporter::builder()
            .with_tonic()
            .with_endpoint(endpoint)
            .with_timeout(PATIENCE)
            .build()
            .map_err(|error| format!("`otlp_endpoint`: {error}"))?;
        let resource = Resource::builder_empty()
            .with_service_name("signorini")
            .with_attribute(KeyValue::new("service.version", env!("CARGO_PKG_VERSION")))
            .build();
        let provider = SdkTracerProvider::builder()
            .with_batch_exporter(exporter)
            .with_resource(resource)
            .build();
        Ok(Self(Some(provider)))
    }

    /// A trace of its own, over with the last clone of what is returned.
    pub(crate) fn update(&self, session: &str, sequence: i64) -> UpdateTrace {
        UpdateTrace(self.0.as_ref().map(|provider| {
            let tracer = provider.tracer("signorini-server");
            let attributes = [
                KeyValue::new("session", session.to_owned()),
                KeyValue::new("sequence", sequence),
            ];
            let builder = SpanBuilder::from_name("update").with_attributes(attributes);
            let span = tracer.build_with_context(builder, &Context::new());
            let context = Context::new().with_span(span);
            Arc::new(Place { tracer, context })
        }))
    }

    /// Sends what has not been sent. Blocks.
    pub(crate) fn close(&self) {
        if let Some(provider) = &self.0
            && let Err(why) = provider.shutdown_with_timeout(PATIENCE)
        {
            tracing::warn!(why = why.to_string(), "the last traces are lost");
        }
    }
}

/// A span under which others lie.
struct Place {
    tracer: SdkTracer,
    context: Context,
}

impl Place {
    /// A span below this one.
    fn below(&self, builder: SpanBuilder) -> Self {
        let span = self.tracer.build_with_context(builder, &self.context);
        Self {
            tracer: self.tracer.clone(),
            context: self.context.with_span(span),
        }
    }
}

/// Of one update.
#[derive(Clone)]
pub(crate) struct UpdateTrace(Option<Arc<Place>>);

impl UpdateTrace {
    /// An increment that begins now.
    pub(crate) fn increment(&self, number: u32) -> IncrementTrace {
        IncrementTrace(self.0.as_ref().map(|update| {
            let attributes = [KeyValue::new("increment", i64::from(number))];
            let builder = SpanBuilder::from_name("increment").with_attributes(attributes);
            Running {
                place: update.below(builder),
                since: SystemTime::now(),
                program: None,
            }
        }))
    }
}

/// Of one increment.
pub(crate) struct IncrementTrace(Option<Running>);

impl IncrementTrace {
    pub(crate) fn iteration(&mut self, record: &IterationRecord) {
        if let Some(running) = &mut self.0 {
            running.iteration(record, SystemTime::now());
        }
    }

    pub(crate) fn finish(self, report: &StepReport) {
        let Some(mut running) = self.0 else { return };
        running.end_program(SystemTime::now());
        let span = running.place.context.span();
        span.set_attribute(KeyValue::new("programs", i64::from(report.sqp_iterations)));
        let iterations = i64::from(report.krylov_iterations);
        span.set_attribute(KeyValue::new("krylov_iterations", iterations));
        let ended = format!("{:?}", report.termination);
        match report.termination {
            Termination::Converged => span.set_status(Status::Ok),
            Termination::NotConverged
            | Termination::Cancelled
            | Termination::DeadlineExceeded
            | Termination::InternalError => span.set_status(Status::error(ended)),
        }
        span.end();
    }
}

/// An increment with the program that is being solved.
struct Running {
    place: Place,
    /// When the last program ended, or the increment began.
    since: SystemTime,
    program: Option<Program>,
}

/// A quadratic program and its Krylov iterations so far.
struct Program {
    number: u32,
    begun: SystemTime,
    first: SystemTime,
    last: SystemTime,
    iterations: u32,
    active: u32,
}

impl Running {
    /// A program begins where the one before ended: iterations are told when they are over.
    fn iteration(&mut self, record: &IterationRecord, now: SystemTime) {
        let number = record.sqp_iteration;
        if self
            .program
            .as_ref()
            .is_some_and(|one| one.number != number)
        {
            let ended = self.program.as_ref().map_or(now, |one| one.last);
            self.end_program(ended);
        }
        let begun = self.since;
        let program = self.program.get_or_insert(Program {
            number,
            begun,
            first: now,
            last: now,
            iterations: 0,
            active: 0,
        });
        program.last = now;
        program.iterations += 1;
        program.active = record.active_vertices;
    }

    fn end_program(&mut self, end: SystemTime) {
        self.since = end;
        let Some(program) = self.program.take() else {
            return;
        };
        let attributes = [
            KeyValue::new("program", i64::from(program.number)),
            KeyValue::new("active_vertices", i64::from(program.active)),
        ];
        let builder = SpanBuilder::from_name("program").with_attributes(attributes);
        let place = self.place.below(builder.with_start_time(program.begun));
        let attributes = [KeyValue::new("iterations", i64::from(program.iterations))];
        let builder = SpanBuilder::from_name("krylov").with_attributes(attributes);
        let builder = builder.with_start_time(program.first);
        let mut krylov = place.tracer.build_with_context(builder, &place.context);
        krylov.end_with_timestamp(program.last);
        place.context.span().end_with_timestamp(end);
    }
}
