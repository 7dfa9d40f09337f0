//! One connection of a stream, made by its source and used up by the pump.

use signorini_proto::v1;
use signorini_proto::v1::solve_request::Message as Request;
use tokio::sync::mpsc;

use super::events::Collector;
use super::incoming::Incoming;

/// One connection.
#[derive(Debug)]
pub(super) struct Link {
    /// `None` when it is half-closed or only reads.
    pub(super) requests: Option<mpsc::Sender<v1::SolveRequest>>,
    /// The answers as they come.
    pub(super) incoming: Incoming,
    /// Puts results together from their messages.
    pub(super) collector: Collector,
}

/// A message on its way to the server.
pub(super) fn request(message: Request) -> v1::SolveRequest {
    v1::SolveRequest {
        message: Some(message),
    }
}
