//! The pages of an operator, plain HTTP on a port of their own: `/metrics` for Prometheus,
//! `/healthz` and `/livez` for probes, `/live` for a browser, and `/`, which says so. Those of a
//! server are on loopback.

use std::convert::Infallible;
#[cfg(feature = "fleet")]
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use http_body_util::Full;
use hyper::body::Incoming;
use hyper::http::request::Parts;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{HeaderMap, Method, Request, Response, StatusCode, header};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpListener;

/// Of everything but the live page.
const PLAIN: &str = "text/plain; version=0.0.4; charset=utf-8";
/// A client that sends its request more slowly is dropped.
const HEADER_TIME: Duration = Duration::from_secs(5);
/// Pause after a failed accept, such as for want of file descriptors.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// What a page answers.
pub(crate) struct Answer {
    pub(crate) status: StatusCode,
    pub(crate) headers: HeaderMap,
    pub(crate) body: Bytes,
}

impl Answer {
    /// Text for programs and people.
    pub(crate) fn plain(status: StatusCode, text: String) -> Self {
        let kind = header::HeaderValue::from_static(PLAIN);
        Self {
            status,
            headers: [(header::CONTENT_TYPE, kind)].into_iter().collect(),
            body: text.into(),
        }
    }
}

/// What stands on such pages.
pub(crate) trait Answers: Clone + Send + Sync + 'static {
    /// What is there for a request.
    fn answer(&self, request: &Parts) -> impl Future<Output = Answer> + Send;
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
        let page = page.clone();
        async move { Ok::<_, Infallible>(respond(&page, &request.into_parts().0).await) }
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
    async fn answer(&self, request: &Parts) -> Answer {
        let (status, text) = match request.uri.path() {
            "/metrics" => (StatusCode::OK, (self.0)()),
            "/healthz" | "/livez" => (StatusCode::OK, "ok\n".to_owned()),
            _ => (
                StatusCode::NOT_FOUND,
                "/metrics  for Prometheus\n".to_owned(),
            ),
        };
        Answer::plain(status, text)
    }
}

/// Serves what `render` gives to Prometheus, at `/metrics`, and says at `/livez` that it answers,
/// until it is dropped.
#[cfg(feature = "fleet")]
pub async fn serve_metrics(listener: TcpListener, render: Arc<dyn Fn() -> String + Send + Sync>) {
    serve(listener, Plain(render)).await;
}

/// The answer; of one to HEAD hyper sends the headers.
async fn respond(page: &impl Answers, request: &Parts) -> Response<Full<Bytes>> {
    if ![Method::GET, Method::HEAD].contains(&request.method) {
        let text = "only GET and HEAD are answered\n".to_owned();
        let mut refusal = Answer::plain(StatusCode::METHOD_NOT_ALLOWED, text);
        let allowed = header::HeaderValue::from_static("GET, HEAD");
        refusal.headers.insert(header::ALLOW, allowed);
        return response(refusal);
    }
    response(page.answer(request).await)
}

fn response(answer: Answer) -> Response<Full<Bytes>> {
    let mut response = Response::new(Full::new(answer.body));
    *response.status_mut() = answer.status;
    *response.headers_mut() = answer.headers;
    response
}
