//! Calls by method and code.
//!
//! Methods are those of the services that are served; whatever else a client asks
//! for is one method `other`, so that nobody can make series.

use std::sync::Arc;
use std::time::Instant;

use metrics::{Key, Label, Recorder};
use tonic::Code;

use super::catalogue::*;
use super::{METADATA, Metrics};

/// How many messages go which way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CallKind {
    Unary,
    ClientStream,
    ServerStream,
    BothStream,
}

impl CallKind {
    /// The name used by go-grpc-middleware.
    fn name(self) -> &'static str {
        match self {
            Self::Unary => "unary",
            Self::ClientStream => "client_stream",
            Self::ServerStream => "server_stream",
            Self::BothStream => "bidi_stream",
        }
    }
}

/// One method that can be called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Method {
    pub(crate) service: String,
    pub(crate) name: String,
    pub(crate) kind: CallKind,
}

impl Method {
    /// What is called and not served.
    pub(crate) fn other() -> Self {
        Self {
            service: "other".to_owned(),
            name: "other".to_owned(),
            kind: CallKind::Unary,
        }
    }

    fn key(&self, metric: &'static str, code: Option<Code>) -> Key {
        let mut labels = vec![
            Label::new("grpc_service", self.service.clone()),
            Label::new("grpc_method", self.name.clone()),
            Label::new("grpc_type", self.kind.name()),
        ];
        labels.extend(code.map(|code| Label::new("grpc_code", code_name(code))));
        Key::from_parts(metric, labels)
    }
}

const CODES: i32 = 17;

/// The name used by go-grpc-middleware.
fn code_name(code: Code) -> &'static str {
    match code {
        Code::Ok => "OK",
        Code::Cancelled => "Canceled",
        Code::Unknown => "Unknown",
        Code::InvalidArgument => "InvalidArgument",
        Code::DeadlineExceeded => "DeadlineExceeded",
        Code::NotFound => "NotFound",
        Code::AlreadyExists => "AlreadyExists",
        Code::PermissionDenied => "PermissionDenied",
        Code::ResourceExhausted => "ResourceExhausted",
        Code::FailedPrecondition => "FailedPrecondition",
        Code::Aborted => "Aborted",
        Code::OutOfRange => "OutOfRange",
        Code::Unimplemented => "Unimplemented",
        Code::Internal => "Internal",
        Code::Unavailable => "Unavailable",
        Code::DataLoss => "DataLoss",
        Code::Unauthenticated => "Unauthenticated",
    }
}

impl Metrics {
    /// Series of a method: all counts, and the times of calls that went well. Those
    /// of the others come with the first: sixteen histograms a method, most of them
    /// empty for ever, would be three quarters of the page.
    pub(crate) fn method(&self, method: &Method) {
        let count = |key| self.recorder.register_counter(&key, &METADATA).increment(0);
        count(method.key(CALLS_STARTED, None));
        for code in (0..CODES).map(Code::from_i32) {
            count(method.key(CALLS_HANDLED, Some(code)));
        }
        let key = method.key(CALL_SECONDS, Some(Code::Ok));
        drop(self.recorder.register_histogram(&key, &METADATA));
    }

    /// Counts a call until the value is dropped.
    pub(crate) fn call(self: &Arc<Self>, method: &Arc<Method>) -> OpenCall {
        let key = method.key(CALLS_STARTED, None);
        self.recorder.register_counter(&key, &METADATA).increment(1);
        OpenCall {
            metrics: Arc::clone(self),
            method: Arc::clone(method),
            start: Instant::now(),
            code: Code::Cancelled,
        }
    }

    /// Counts bytes of messages from clients.
    pub(crate) fn received(&self, bytes: usize) {
        self.received.increment(bytes as u64);
    }

    /// Counts bytes of messages to clients.
    pub(crate) fn sent(&self, bytes: usize) {
        self.sent.increment(bytes as u64);
    }
}

/// A call that has not ended.
pub(crate) struct OpenCall {
    metrics: Arc<Metrics>,
    method: Arc<Method>,
    start: Instant,
    /// Cancelled until an answer has a code: then the client has left before.
    code: Code,
}

impl OpenCall {
    /// The call was answered so, and has ended.
    pub(crate) fn answered(mut self, code: Code) {
        self.code = code;
    }
}

impl Drop for OpenCall {
    fn drop(&mut self) {
        let recorder = &self.metrics.recorder;
        let key = self.method.key(CALLS_HANDLED, Some(self.code));
        recorder.register_counter(&key, &METADATA).increment(1);
        let key = self.method.key(CALL_SECONDS, Some(self.code));
        recorder
            .register_histogram(&key, &METADATA)
            .record(self.start.elapsed());
    }
}
