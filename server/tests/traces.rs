//! Traces as a collector gets them: what is sent is read by messages of this test's own, with the
//! numbers of opentelemetry-proto.

mod common;

use std::convert::Infallible;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll};
use std::time::Duration;

use common::{Block, Server, open, press};
use prost::Message;
use signorini_server::Config;
use tonic::body::Body;
use tonic::codegen::{BoxFuture, Service, http};
use tonic::server::{Grpc, NamedService, UnaryService};
use tonic_prost::ProstCodec;

#[derive(Clone, PartialEq, Message)]
struct ExportRequest {
    #[prost(message, repeated, tag = "1")]
    resources: Vec<ResourceSpans>,
}

#[derive(Clone, PartialEq, Message)]
struct ResourceSpans {
    #[prost(message, optional, tag = "1")]
    resource: Option<Resource>,
    #[prost(message, repeated, tag = "2")]
    scopes: Vec<ScopeSpans>,
}

#[derive(Clone, PartialEq, Message)]
struct Resource {
    #[prost(message, repeated, tag = "1")]
    attributes: Vec<KeyValue>,
}

#[derive(Clone, PartialEq, Message)]
struct ScopeSpans {
    #[prost(message, repeated, tag = "2")]
    spans: Vec<Span>,
}

#[derive(Clone, PartialEq, Message)]
struct Span {
    #[prost(bytes = "vec", tag = "1")]
    trace: Vec<u8>,
    #[prost(bytes = "vec", tag = "2")]
    id: Vec<u8>,
    #[prost(bytes = "vec", tag = "4")]
    parent: Vec<u8>,
    #[prost(string, tag = "5")]
    name: String,
    #[prost(fixed64, tag = "7")]
    start: u64,
    #[prost(fixed64, tag = "8")]
    end: u64,
    #[prost(message, repeated, tag = "9")]
    attributes: Vec<KeyValue>,
}

#[derive(Clone, PartialEq, Message)]
struct KeyValue {
    #[prost(string, tag = "1")]
    key: String,
    #[prost(message, optional, tag = "2")]
    value: Option<AnyValue>,
}

#[derive(Clone, PartialEq, Message)]
struct AnyValue {
    #[prost(string, optional, tag = "1")]
    text: Option<String>,
    #[prost(int64, optional, tag = "3")]
    number: Option<i64>,
}

#[derive(Clone, PartialEq, Message)]
struct ExportResponse {}

impl Span {
    fn number(&self, key: &str) -> i64 {
        let found = self.attributes.iter().find(|one| one.key == key);
        found.unwrap().value.as_ref().unwrap().number.unwrap()
    }

    fn is_within(&self, other: &Self) -> bool {
        self.parent == other.id
            && self.trace == other.trace
            && other.start <= self.start
            && self.start <= self.end
            && self.end <= other.end
    }
}

/// A collector that keeps what it gets.
#[derive(Clone, Default)]
struct Collector(Arc<Mutex<Vec<ResourceSpans>>>);

impl NamedService for Collector {
    const NAME: &'static str = "opentelemetry.proto.collector.trace.v1.TraceService";
}

impl UnaryService<ExportRequest> for Collector {
    type Response = ExportResponse;
    type Future = BoxFuture<tonic::Response<ExportResponse>, tonic::Status>;

    fn call(&mut self, request: tonic::Request<ExportRequest>) -> Self::Future {
        self.0
            .lock()
            .unwrap()
            .extend(request.into_inner().resources);
        Box::pin(async { Ok(tonic::Response::new(ExportResponse {})) })
    }
}

impl Service<http::Request<Body>> for Collector {
    type Response = http::Response<Body>;
    type Error = Infallible;
    type Future = BoxFuture<Self::Response, Infallible>;

    fn poll_ready(&mut self, _: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        Poll::Ready(Ok(()))
    }

    fn call(&mut self, request: http::Request<Body>) -> Self::Future {
        assert!(request.uri().path().ends_with("/Export"));
        let collector = self.clone();
        let codec = ProstCodec::<ExportResponse, ExportRequest>::default();
        Box::pin(async move { Ok(Grpc::new(codec).unary(collector, request).await) })
    }
}

impl Collector {
    /// Where it listens.
    async fn start(&self) -> String {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let incoming = tokio_stream::wrappers::TcpListenerStream::new(listener);
        let router = tonic::transport::Server::builder().add_service(self.clone());
        tokio::spawn(router.serve_with_incoming(incoming));
        format!("http://{address}")
    }

    fn spans(&self, name: &str) -> Vec<Span> {
        let all = self.0.lock().unwrap();
        let spans = all.iter().flat_map(|one| &one.scopes);
        let spans = spans.flat_map(|one| &one.spans);
        spans.filter(|span| span.name == name).cloned().collect()
    }
}

async fn with(endpoint: &str) -> Server {
    Server::with(Config {
        otlp_endpoint: endpoint.to_owned(),
        ..Config::embedded()
    })
    .await
}

/// Two updates, the second of two increments: programs and Krylov iterations of each increment.
async fn solve(mut server: Server) -> Vec<(i64, i64)> {
    let block = Block::new(2);
    server.upload(&block).await;
    let name = server.session(block.scene()).await;
    let mut stream = server.open(open(&name)).await;
    let mut counts = Vec::new();
    for (sequence, increments) in [(1, 1), (2, 2)] {
        stream
            .step(sequence, press(0.02 * sequence as f64, increments))
            .await;
        for _ in 0..increments {
            let report = stream.result().await.report.unwrap();
            let (programs, iterations) = (report.sqp_iterations, report.krylov_iterations);
            counts.push((i64::from(programs), i64::from(iterations)));
        }
    }
    drop(stream);
    server.signal_stop();
    server.stopped().await.unwrap();
    counts
}

#[tokio::test(flavor = "multi_thread")]
async fn a_collector_gets_updates_with_their_increments_programs_and_iterations() {
    let collector = Collector::default();
    let expected = solve(with(&collector.start().await).await).await;
    let service = collector.0.lock().unwrap()[0].clone().resource.unwrap();
    let service = service
        .attributes
        .iter()
        .find(|one| one.key == "service.name");
    let service = service.unwrap().value.clone().unwrap().text;
    assert_eq!(service.as_deref(), Some("signorini"));
    let mut updates = collector.spans("update");
    updates.sort_by_key(|update| update.number("sequence"));
    assert_eq!(updates.len(), 2);
    assert!(updates.iter().all(|update| update.parent.is_empty()));
    assert_ne!(updates[0].trace, updates[1].trace);
    let mut increments = collector.spans("increment");
    increments.sort_by_key(|increment| increment.start);
    let within = |one: &Span| updates.iter().position(|update| one.is_within(update));
    let places: Vec<_> = increments.iter().map(within).collect();
    assert_eq!(places, [Some(0), Some(1), Some(1)]);
    let (programs, krylov) = (collector.spans("program"), collector.spans("krylov"));
    for (increment, (count, iterations)) in increments.iter().zip(expected) {
        assert_eq!(increment.number("krylov_iterations"), iterations);
        let own: Vec<_> = programs
            .iter()
            .filter(|one| one.is_within(increment))
            .collect();
        assert!(!own.is_empty() && own.len() as i64 <= count, "{own:?}");
        let of = |program: &&&Span| {
            let inside: Vec<_> = krylov.iter().filter(|one| one.is_within(program)).collect();
            assert_eq!(inside.len(), 1);
            inside[0].number("iterations")
        };
        assert_eq!(own.iter().map(|one| of(&one)).sum::<i64>(), iterations);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_collector_that_is_not_there_holds_up_nothing() {
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let endpoint = format!("http://{}", free.local_addr().unwrap());
    drop(free);
    let begun = std::time::Instant::now();
    solve(with(&endpoint).await).await;
    assert!(
        begun.elapsed() < Duration::from_secs(20),
        "{:?}",
        begun.elapsed()
    );
}
