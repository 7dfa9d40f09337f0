//! A tower layer from one function: what is done around each call, before it with the request
//! and after it with the answer. A layer is always ready when what it surrounds is.

use std::convert::Infallible;
use std::task::{Context, Poll};

use tonic::body::Body;
use tonic::codegen::{BoxFuture, Service, http};
use tonic::server::NamedService;
use tower::Layer;

pub(crate) type Request = http::Request<Body>;
pub(crate) type Response = http::Response<Body>;
/// The answer to a call, when it comes.
pub(crate) type Answer = BoxFuture<Response, Infallible>;

/// The future of an inner service.
pub(crate) trait Reply:
    Future<Output = Result<Response, Infallible>> + Send + 'static
{
}

impl<F: Future<Output = Result<Response, Infallible>> + Send + 'static> Reply for F {}

/// What a layer does around a call.
pub(crate) trait AroundCall: Clone {
    /// Answers `request`, by `inner` where it goes on.
    fn call<F: Reply>(&self, request: Request, inner: impl FnOnce(Request) -> F) -> Answer;
}

/// Puts what is done around a call around services.
#[derive(Clone)]
pub(crate) struct CallLayer<A>(pub(crate) A);

impl<A: Clone, S> Layer<S> for CallLayer<A> {
    type Service = Surrounded<A, S>;

    fn layer(&self, inner: S) -> Surrounded<A, S> {
        let around = self.0.clone();
        Surrounded { around, inner }
    }
}

/// Services with something around their calls.
#[derive(Clone)]
pub(crate) struct Surrounded<A, S> {
    around: A,
    inner: S,
}

impl<A, S: NamedService> NamedService for Surrounded<A, S> {
    const NAME: &'static str = S::NAME;
}

impl<A: AroundCall, S> Service<Request> for Surrounded<A, S>
where
    S: Service<Request, Response = Response, Error = Infallible>,
    S::Future: Send + 'static,
{
    type Response = Response;
    type Error = Infallible;
    type Future = Answer;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        self.inner.poll_ready(context)
    }

    fn call(&mut self, request: Request) -> Answer {
        let Self { around, inner } = self;
        around.call(request, |request| inner.call(request))
    }
}
