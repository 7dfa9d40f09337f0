//! The gate before all services: what a unary call took is given back with its answer.

use std::convert::Infallible;
use std::sync::Arc;
use std::task::{Context, Poll};

use tonic::body::Body;
use tonic::codegen::{BoxFuture, Service, http};
use tower::Layer;

use super::body::{Gated, Kept};
use super::decode::Decode;
use crate::client_key::Peer;

/// Puts the gate before the services.
#[derive(Clone)]
pub(crate) struct GateMessages(pub(crate) Arc<Decode>);

impl<S> Layer<S> for GateMessages {
    type Service = Guarded<S>;

    fn layer(&self, inner: S) -> Guarded<S> {
        let gate = Arc::clone(&self.0);
        Guarded { inner, gate }
    }
}

/// Services behind the gate.
#[derive(Clone)]
pub(crate) struct Guarded<S> {
    inner: S,
    gate: Arc<Decode>,
}

impl<S> Service<http::Request<Body>> for Guarded<S>
where
    S: Service<http::Request<Body>, Response = http::Response<Body>, Error = Infallible>,
    S::Future: Send + 'static,
{
    type Response = http::Response<Body>;
    type Error = Infallible;
    type Future = BoxFuture<Self::Response, Infallible>;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        self.inner.poll_ready(context)
    }

    fn call(&mut self, request: http::Request<Body>) -> Self::Future {
        let method = self.gate.shapes.method(request.uri().path());
        let kept = Kept::default();
        let (shape, is_stream) = method.unzip();
        let peer = request.extensions().get::<Peer>();
        let client = peer.unwrap_or(&Peer::UNKNOWN).client.identity;
        let request = request.map(|inner| {
            let keeps = is_stream == Some(false);
            let kept = keeps.then(|| Arc::clone(&kept));
            let door = (Arc::clone(&self.gate), client);
            Body::new(Gated::new(inner, door, shape, kept))
        });
        let (answer, gate) = (self.inner.call(request), Arc::clone(&self.gate));
        Box::pin(async move {
            let response = answer.await?;
            drop(kept);
            gate.show();
            Ok(response)
        })
    }
}
