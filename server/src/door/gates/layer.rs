//! The gate before all services: what a unary call took is given back with its answer.

use std::sync::Arc;

use tonic::body::Body;

use super::body::{Gated, Kept};
use super::decode::Decode;
use crate::door::client_key::Peer;
use crate::door::layer::{Answer, AroundCall, Reply, Request};

/// Holds messages to their budget before they are decoded.
#[derive(Clone)]
pub(crate) struct GateMessages(pub(crate) Arc<Decode>);

impl AroundCall for GateMessages {
    fn call<F: Reply>(&self, request: Request, inner: impl FnOnce(Request) -> F) -> Answer {
        let method = self.0.shapes.method(request.uri().path());
        let kept = Kept::default();
        let (shape, is_stream) = method.unzip();
        let peer = request.extensions().get::<Peer>();
        let client = peer.unwrap_or(&Peer::UNKNOWN).client.identity;
        let request = request.map(|body| {
            let keeps = is_stream == Some(false);
            let kept = keeps.then(|| Arc::clone(&kept));
            let door = (Arc::clone(&self.0), client);
            Body::new(Gated::new(body, door, shape, kept))
        });
        let (answer, gate) = (inner(request), Arc::clone(&self.0));
        Box::pin(async move {
            let response = answer.await?;
            drop(kept);
            gate.show();
            Ok(response)
        })
    }
}
