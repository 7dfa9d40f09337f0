//! The answers of one connection, and whether its end is the service's will or
//! the network's fault.

use signorini_proto::v1;
use signorini_proto::v1::solve_response::Message as Response;
use signorini_proto::v1::watch_response::Message as Watched;
use tonic::Streaming;

use crate::library::breaks::{Stop, broken};
use crate::library::mesh::missing;

/// Answers of either stream.
#[derive(Debug)]
pub(super) enum Incoming {
    /// Of the one that drives the session.
    Solve(Streaming<v1::SolveResponse>),
    /// Of one that only reads.
    Watch(Streaming<v1::WatchResponse>),
}

impl Incoming {
    /// The next message; `None` when the service has ended the stream well.
    /// Nothing is lost when the future is dropped.
    pub(super) async fn next(&mut self) -> Result<Option<Response>, Stop> {
        match self {
            Self::Solve(stream) => match stream.message().await? {
                Some(response) => content(response.message),
                None => ended(stream).await,
            },
            Self::Watch(stream) => match stream.message().await? {
                Some(response) => content(response.message.map(as_solved)),
                None => ended(stream).await,
            },
        }
    }

    /// The message that every stream starts with.
    pub(super) async fn opened(&mut self) -> Result<v1::StreamOpened, Stop> {
        match self.next().await? {
            Some(Response::Opened(opened)) => Ok(opened),
            _ => Err(missing("the first message `opened`").into()),
        }
    }
}

fn content(message: Option<Response>) -> Result<Option<Response>, Stop> {
    let message = message.ok_or_else(|| missing("the content of a message"))?;
    Ok(Some(message))
}

/// Trailers tell an end from a body that was cut off.
async fn ended<T>(stream: &mut Streaming<T>) -> Result<Option<Response>, Stop> {
    match stream.trailers().await? {
        Some(_) => Ok(None),
        None => Err(broken("the stream was cut off".to_owned())),
    }
}

fn as_solved(message: Watched) -> Response {
    match message {
        Watched::Opened(opened) => Response::Opened(opened),
        Watched::Iteration(statistics) => Response::Iteration(statistics),
        Watched::StepFinished(finished) => Response::StepFinished(finished),
        Watched::Field(chunk) => Response::Field(chunk),
        Watched::Heartbeat(heartbeat) => Response::Heartbeat(heartbeat),
    }
}
