//! Answers that a client leaves untaken.
//!
//! The transport asks for the next frame of an answer when it may send one (RFC 9113, 5.2). Between a
//! frame and that question the answer waits for its client, which may never let it go on; nothing but the
//! end of the connection ends it then. So each connection knows since when its answers wait, and
//! closes when one has waited too long. Cost: one look at the clock each frame.

use std::collections::HashMap;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

use bytes::Bytes;
use hyper::body::{Body as HttpBody, Frame, SizeHint};
use tonic::Status;
use tonic::body::Body;

use super::client_key::Peer;
use super::layer::{Answer, AroundCall, Reply, Request};

/// Since when the answers of a connection wait for their client.
#[derive(Debug, Default)]
pub(crate) struct Untaken(Mutex<Waiting>);

#[derive(Debug, Default)]
struct Waiting {
    next: u64,
    since: HashMap<u64, Instant>,
}

impl Untaken {
    /// How long the one has waited that waits longest.
    pub(super) fn longest(&self) -> Duration {
        let waiting = self.lock();
        let first = waiting.since.values().min();
        first.map_or(Duration::ZERO, Instant::elapsed)
    }

    fn enter(&self) -> u64 {
        let mut waiting = self.lock();
        waiting.next += 1;
        waiting.next
    }

    fn waits(&self, number: u64) {
        self.lock().since.insert(number, Instant::now());
    }

    fn goes_on(&self, number: u64) {
        self.lock().since.remove(&number);
    }

    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What a connection tells of itself with each request.
#[derive(Clone, Debug)]
pub(crate) struct Incoming {
    pub(crate) peer: Peer,
    pub(crate) untaken: Arc<Untaken>,
}

/// Tells each connection which of its answers wait, and the other layers who is there.
#[derive(Clone)]
pub(crate) struct WatchAnswers;

impl AroundCall for WatchAnswers {
    fn call<F: Reply>(&self, mut request: Request, inner: impl FnOnce(Request) -> F) -> Answer {
        let Some(incoming) = request.extensions_mut().remove::<Incoming>() else {
            return Box::pin(inner(request));
        };
        request.extensions_mut().insert(incoming.peer);
        let answer = inner(request);
        Box::pin(async move {
            let response = answer.await?;
            Ok(response.map(|inner| Body::new(Watched::new(inner, incoming.untaken))))
        })
    }
}

/// An answer that its connection knows of.
struct Watched {
    inner: Body,
    number: u64,
    untaken: Arc<Untaken>,
}

impl Watched {
    fn new(inner: Body, untaken: Arc<Untaken>) -> Self {
        let number = untaken.enter();
        untaken.waits(number);
        Self {
            inner,
            number,
            untaken,
        }
    }
}

impl HttpBody for Watched {
    type Data = Bytes;
    type Error = Status;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Status>>> {
        self.untaken.goes_on(self.number);
        let next = Pin::new(&mut self.inner).poll_frame(context);
        if matches!(next, Poll::Ready(Some(_))) {
            self.untaken.waits(self.number);
        }
        next
    }

    fn is_end_stream(&self) -> bool {
        self.inner.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.inner.size_hint()
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        self.untaken.goes_on(self.number);
    }
}

#[cfg(test)]
mod tests {
    use http_body_util::BodyExt as _;

    use super::*;

    fn body(untaken: &Arc<Untaken>, text: &'static str) -> Watched {
        let inner = Body::new(
            http_body_util::Full::new(Bytes::from_static(text.as_bytes()))
                .map_err(|never| match never {}),
        );
        Watched::new(inner, Arc::clone(untaken))
    }

    #[tokio::test]
    async fn an_answer_waits_from_its_frame_until_the_next_is_asked_for() {
        let untaken = Arc::<Untaken>::default();
        assert_eq!(untaken.longest(), Duration::ZERO);
        let mut taken = body(&untaken, "one");
        let mut left = body(&untaken, "two");
        tokio::time::sleep(Duration::from_millis(30)).await;
        assert!(
            untaken.longest() >= Duration::from_millis(30),
            "nobody asked for a frame"
        );
        for one in [&mut taken, &mut left] {
            assert!(one.frame().await.is_some_and(|frame| frame.is_ok()));
        }
        assert!(taken.frame().await.is_none());
        tokio::time::sleep(Duration::from_millis(30)).await;
        assert!(untaken.longest() >= Duration::from_millis(30));
        drop(left);
        assert_eq!(
            untaken.longest(),
            Duration::ZERO,
            "one was taken, one is gone"
        );
    }
}
