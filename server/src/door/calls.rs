//! A layer around all services that counts calls: how many, how long, how they
//! ended, and bytes of their messages both ways. Cost: one look at each frame.

use std::collections::HashMap;
use std::sync::Arc;

use bytes::Bytes;
use http_body_util::BodyExt as _;
use hyper::body::Frame;
use prost::Message as _;
use prost_types::{FileDescriptorSet, MethodDescriptorProto};
use signorini_proto::FILE_DESCRIPTOR_SET;
use tonic::body::Body;
use tonic::codegen::http;
use tonic::{Code, Status};

use super::layer::{Answer, AroundCall, Reply, Request, Response};
use crate::watch::metrics::{CallKind, Method, Metrics, OpenCall};

/// The methods by path, and where they are counted.
pub(crate) struct Methods {
    by_path: HashMap<String, Arc<Method>>,
    other: Arc<Method>,
    metrics: Arc<Metrics>,
}

impl Methods {
    /// The methods of the service and of its health, with their series.
    ///
    /// # Errors
    /// When a descriptor cannot be read, which no input can cause.
    pub(crate) fn new(metrics: &Arc<Metrics>) -> Result<Self, prost::DecodeError> {
        let mut by_path = HashMap::new();
        for set in [FILE_DESCRIPTOR_SET, tonic_health::pb::FILE_DESCRIPTOR_SET] {
            for method in methods(&FileDescriptorSet::decode(set)?) {
                metrics.method(&method);
                let path = format!("/{}/{}", method.service, method.name);
                by_path.insert(path, Arc::new(method));
            }
        }
        let other = Method::other();
        metrics.method(&other);
        Ok(Self {
            by_path,
            other: Arc::new(other),
            metrics: Arc::clone(metrics),
        })
    }

    fn call(&self, path: &str) -> OpenCall {
        let method = self.by_path.get(path).unwrap_or(&self.other);
        self.metrics.call(method)
    }
}

fn methods(set: &FileDescriptorSet) -> Vec<Method> {
    let mut all = Vec::new();
    for file in &set.file {
        for service in &file.service {
            let name = format!("{}.{}", file.package(), service.name());
            all.extend(service.method.iter().map(|one| method(&name, one)));
        }
    }
    all
}

fn method(service: &str, method: &MethodDescriptorProto) -> Method {
    Method {
        service: service.to_owned(),
        name: method.name().to_owned(),
        kind: match (method.client_streaming(), method.server_streaming()) {
            (false, false) => CallKind::Unary,
            (true, false) => CallKind::ClientStream,
            (false, true) => CallKind::ServerStream,
            (true, true) => CallKind::BothStream,
        },
    }
}

/// Counts the calls of services.
#[derive(Clone)]
pub(crate) struct CountCalls(pub(crate) Arc<Methods>);

impl AroundCall for CountCalls {
    fn call<F: Reply>(&self, request: Request, inner: impl FnOnce(Request) -> F) -> Answer {
        let call = self.0.call(request.uri().path());
        let metrics = Arc::clone(&self.0.metrics);
        let count = move |frame: Frame<Bytes>| {
            metrics.received(frame.data_ref().map_or(0, Bytes::len));
            frame
        };
        let answer = inner(request.map(|body| Body::new(body.map_frame(count))));
        let metrics = Arc::clone(&self.0.metrics);
        Box::pin(async move { Ok(counted(answer.await?, call, metrics)) })
    }
}

/// The response, which takes its call along unless the headers have the code already:
/// then that comes with the trailers, or never, when the client leaves before.
fn counted(response: Response, call: OpenCall, metrics: Arc<Metrics>) -> Response {
    let mut call = still_open(call, response.headers());
    let see = move |frame: Frame<Bytes>| {
        metrics.sent(frame.data_ref().map_or(0, Bytes::len));
        if let Some(trailers) = frame.trailers_ref() {
            call = call.take().and_then(|call| still_open(call, trailers));
        }
        frame
    };
    response.map(|body| Body::new(body.map_frame(see)))
}

/// Ends the call if `headers` have its code.
fn still_open(call: OpenCall, headers: &http::HeaderMap) -> Option<OpenCall> {
    let Some(code) = headers.get(Status::GRPC_STATUS) else {
        return Some(call);
    };
    call.answered(Code::from_bytes(code.as_bytes()));
    None
}
