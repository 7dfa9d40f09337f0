//! Where a stream comes from: a session that is driven, or one that is watched.

use std::future::Future;
use std::pin::Pin;
use std::time::Duration;

use signorini_proto::v1;
use signorini_proto::v1::solve_request::Message as Request;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;

use super::QUEUE;
use super::incoming::Incoming;
use super::journal::Journal;
use super::link::{Link, request};
use super::options::{Attach, WatchOptions};
use crate::library::breaks::Stop;
use crate::library::connect::Client;
use crate::library::error::ClientError;

/// A connection that is being opened.
pub(super) type Attaching =
    Pin<Box<dyn Future<Output = Result<(v1::StreamOpened, Link), Stop>> + Send>>;

/// What is opened again after a break.
#[derive(Clone, Debug)]
pub(super) struct Source {
    pub(super) client: Client,
    /// Name of the resource.
    pub(super) session: String,
    pub(super) kind: Kind,
}

#[derive(Clone, Debug)]
pub(super) enum Kind {
    Solve(Attach),
    Watch(WatchOptions),
}

impl Source {
    pub(super) fn patience(&self) -> Duration {
        match &self.kind {
            Kind::Solve(attach) => attach.patience,
            Kind::Watch(options) => options.patience,
        }
    }

    pub(super) fn last_seen_event(&self) -> Option<i64> {
        match &self.kind {
            Kind::Solve(attach) => attach.last_seen_event,
            Kind::Watch(options) => options.last_seen_event,
        }
    }

    /// Opens a connection that goes on after a result.
    pub(super) fn attach(self, seen: Option<i64>) -> Attaching {
        Box::pin(async move {
            let mut link = match &self.kind {
                Kind::Solve(attach) => self.solve(attach, seen).await?,
                Kind::Watch(options) => self.watch(options, seen).await?,
            };
            let opened = link.incoming.opened().await?;
            Ok((opened, link))
        })
    }

    async fn solve(&self, attach: &Attach, seen: Option<i64>) -> Result<Link, Stop> {
        let (requests, outgoing) = mpsc::channel(QUEUE);
        let grace = Some(attach.disconnect_grace).filter(|grace| !grace.is_zero());
        let open = Request::Open(v1::SolveOpen {
            session: self.session.clone(),
            last_seen_event: seen,
            fields: attach.fields.iter().copied().map(i32::from).collect(),
            element_type: v1::ElementType::F64.into(),
            max_unread_bytes: 0,
            on_disconnect: attach.on_disconnect.into(),
            iteration_interval: wire(attach.iteration_interval, "the iteration interval")?,
            disconnect_grace: wire(grace, "the time to come back")?,
        });
        // Queued before the call: the server's answer waits for it.
        let queued = requests.send(request(open)).await;
        queued.map_err(|_| ClientError::Closed)?;
        let outgoing = ReceiverStream::new(outgoing);
        let response = self.client.sessions().solve(outgoing).await?;
        Ok(link(Some(requests), Incoming::Solve(response.into_inner())))
    }

    async fn watch(&self, options: &WatchOptions, seen: Option<i64>) -> Result<Link, Stop> {
        let request = v1::WatchRequest {
            name: self.session.clone(),
            last_seen_event: seen,
            fields: options.fields.iter().copied().map(i32::from).collect(),
            element_type: v1::ElementType::F64.into(),
            max_unread_bytes: 0,
            iteration_interval: wire(options.iteration_interval, "the iteration interval")?,
            until: options.until.into(),
        };
        let response = self.client.sessions().watch(request).await?;
        Ok(link(None, Incoming::Watch(response.into_inner())))
    }

    /// Whether a stream that ends well ends here.
    pub(super) fn ends(&self, journal: &Journal) -> bool {
        match &self.kind {
            Kind::Solve(_) => journal.is_answered(),
            Kind::Watch(_) => true,
        }
    }
}

fn link(requests: Option<mpsc::Sender<v1::SolveRequest>>, incoming: Incoming) -> Link {
    Link {
        requests,
        incoming,
        collector: Default::default(),
    }
}

/// A duration on the wire.
pub(super) fn wire(
    duration: Option<Duration>,
    what: &str,
) -> Result<Option<prost_types::Duration>, ClientError> {
    duration
        .map(prost_types::Duration::try_from)
        .transpose()
        .map_err(|_| ClientError::Protocol(format!("{what} is too long")))
}
