//! The page of an operator, plain HTTP on a port of its own: `/metrics` for Prometheus, `/healthz`
//! and `/livez` for probes, and `/`, which says so. That of a server is on loopback.

use std::convert::Infallible;
#[cfg(feature = "fleet")]
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use http_body_util::Full;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode, header};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpListener;

const CONTENT_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";
/// A client that sends its request more slowly is dropped.
const HEADER_TIME: Duration = Duration::from_secs(5);
/// Pause after a failed accept, such as for want of file descriptors.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// What stands on such pages.
pub(crate) trait Answers: Clone + Send + Sync + 'static {
    /// What is there at a path.
    fn answer(&self, path: &str) -> (StatusCode, String);
}

/// Serves pages until it is dropped.
pub(crate) async fn serve(listener: TcpListener, page: impl Answers) {
    loop {
        match listener.accept().await {
            Ok((stream, _)) => {
                tokio::spawn(answer(TokioIo::new(stream), page.clone()));
            }
            Err(error) => {
                tracing::warn!(cause = error.to_string(), "the metrics page cannot accept");
                tokio::time::sleep(ACCEPT_PAUSE).await;
            }
        }
    }
}

async fn answer(stream: TokioIo<tokio::net::TcpStream>, page: impl Answers) {
    let service = service_fn(move |request: Request<Incoming>| {
        let response = respond(&page, request.method(), request.uri().path());
        async move { Ok::<_, Infallible>(response) }
    });
    let outcome = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEADER_TIME)
        .serve_connection(stream, service)
        .await;
    if let Err(error) = outcome {
        tracing::debug!(
            cause = error.to_string(),
            "a reader of the metrics page left"
        );
    }
}

/// The page of a program that is no server.
#[cfg(feature = "fleet")]
#[derive(Clone)]
struct Plain(Arc<dyn Fn() -> String + Send + Sync>);

#[cfg(feature = "fleet")]
impl Answers for Plain {
    fn answer(&self, path: &str) -> (StatusCode, String) {
        match path {
            "/metrics" => (StatusCode::OK, (self.0)()),
            "/healthz" | "/livez" => (StatusCode::OK, "ok\n".to_owned()),
            _ => (
                StatusCode::NOT_FOUND,
                "/metrics  for Prometheus\n".to_owned(),
            ),
        }
    }
}

/// Serves what `render` gives to Prometheus, at `/metrics`, and says at `/livez` that it answers,
/// until it is dropped.
#[cfg(feature = "fleet")]
pub async fn serve_metrics(listener: TcpListener, render: Arc<dyn Fn() -> String + Send + Sync>) {
    serve(listener, Plain(render)).await;
}

/// The answer; of one to HEAD hyper sends the headers.
fn respond(page: &impl Answers, method: &Method, path: &str) -> Response<Full<Bytes>> {
    if ![Method::GET, Method::HEAD].contains(method) {
        let text = "only GET and HEAD are answered\n".to_owned();
        return response(StatusCode::METHOD_NOT_ALLOWED, text);
    }
    let (status, text) = page.answer(path);
    response(status, text)
}

fn response(status: StatusCode, text: String) -> Response<Full<Bytes>> {
    let mut response = Response::new(Full::new(Bytes::from(text)));
    *response.status_mut() = status;
    let headers = response.headers_mut();
    let kind = header::HeaderValue::from_static(CONTENT_TYPE);
    headers.insert(header::CONTENT_TYPE, kind);
    if status == StatusCode::METHOD_NOT_ALLOWED {
        let allowed = header::HeaderValue::from_static("GET, HEAD");
        headers.insert(header::ALLOW, allowed);
    }
    response
}
