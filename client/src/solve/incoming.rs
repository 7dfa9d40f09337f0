//! The answers of one connection, and whether its end is the service's will or
//! the network's fault.

use std::error::Error as _;

use signorini_proto::v1;
use signorini_proto::v1::solve_response::Message as Response;
use signorini_proto::v1::watch_response::Message as Watched;
use tonic::{Code, Status, Streaming};

use crate::connect::root_cause;
use crate::error::{ClientError, Refusal, Unanswered};
use crate::mesh::missing;

/// Answers of either stream.
#[derive(Debug)]
pub(super) enum Incoming {
    /// Of the one that drives the session.
    Solve(Streaming<v1::SolveResponse>),
    /// Of one that only reads.
    Watch(Streaming<v1::WatchResponse>),
}

/// Why no answer follows.
#[derive(Debug)]
pub(super) enum Stop {
    /// The connection broke; another may go on.
    Broken(ClientError),
    /// The service says so, or nobody can go on.
    Fault(ClientError),
}

impl From<ClientError> for Stop {
    fn from(error: ClientError) -> Self {
        Self::Fault(error)
    }
}

impl From<Status> for Stop {
    /// A status that the service or a gateway wrote has no source; one that this
    /// side made from a failure of the transport has.
    fn from(status: Status) -> Self {
        let refusal = Refusal::from(&status);
        let gateway = is_of_gateway(&status) && refusal.reason.is_empty();
        // The session is in the data folder of a server that is being restarted, or
        // whose disk is full.
        let resumes = refusal
            .metadata
            .get("resumes")
            .is_some_and(|value| value == "true");
        match status.source() {
            Some(source) if source.is::<Unanswered>() => Self::Broken(status.into()),
            Some(source) => broken(root_cause(source)),
            None if gateway || resumes => broken(status.message().to_owned()),
            None => Self::Fault(status.into()),
        }
    }
}

/// Whether a status without a reason comes from something between here and the service.
fn is_of_gateway(status: &Status) -> bool {
    // A page of HTML in place of an answer: tonic finds no message in it and tells the
    // status of HTTP.
    let pages = [
        "502 Bad Gateway",
        "503 Service Unavailable",
        "504 Gateway Timeout",
    ];
    let code = status.code();
    let is_page = pages.iter().any(|page| status.message().contains(page));
    matches!(code, Code::Unavailable | Code::Cancelled)
        || (matches!(code, Code::Internal | Code::Unknown) && is_page)
}

impl From<Stop> for ClientError {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::Broken(error) | Stop::Fault(error) => error,
        }
    }
}

fn broken(message: String) -> Stop {
    Stop::Broken(ClientError::Broken { message })
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

#[cfg(test)]
mod tests {
    use std::io;

    use tonic_types::{ErrorDetails, StatusExt as _};

    use super::*;

    fn said(code: Code, reason: &str) -> Status {
        let details = ErrorDetails::with_error_info(reason, "signorini", []);
        Status::with_error_details(code, "no", details)
    }

    #[test]
    fn what_the_service_says_is_final() {
        for (code, reason) in [
            (Code::Aborted, "SESSION_DELETED"),
            (Code::Unavailable, "SHUTTING_DOWN"),
            (Code::NotFound, "SESSION_EXPIRED"),
            (Code::Internal, "INTERNAL"),
        ] {
            let Stop::Fault(ClientError::Refused(refusal)) = Stop::from(said(code, reason)) else {
                unreachable!("{reason}")
            };
            assert_eq!(refusal.reason, reason);
        }
        let missing = Status::unimplemented("no such method");
        assert!(matches!(Stop::from(missing), Stop::Fault(_)));
    }

    #[test]
    fn a_session_that_goes_on_later_is_waited_for() {
        let metadata = [("resumes".to_owned(), "true".to_owned())];
        let details = ErrorDetails::with_error_info("SHUTTING_DOWN", "signorini", metadata);
        let said = Status::with_error_details(Code::Unavailable, "no", details);
        assert!(matches!(Stop::from(said), Stop::Broken(_)));
    }

    #[test]
    fn failures_of_the_transport_and_of_gateways_are_breaks() {
        let reset = io::Error::new(io::ErrorKind::ConnectionReset, "reset by peer");
        let Stop::Broken(cause) = Stop::from(Status::from_error(reset.into())) else {
            unreachable!()
        };
        assert!(
            cause.to_string().ends_with("broke: reset by peer"),
            "{cause}"
        );
        let page = "protocol error: received message with invalid compression flag: 60 (valid \
                    flags are 0 and 1) while receiving response with status: 502 Bad Gateway";
        for gateway in [
            Status::unavailable("no upstream"),
            Status::cancelled("stream reset"),
            Status::internal(page),
        ] {
            assert!(matches!(Stop::from(gateway), Stop::Broken(_)));
        }
        let other = page.replace("502 Bad Gateway", "200 OK");
        assert!(matches!(
            Stop::from(Status::internal(other)),
            Stop::Fault(_)
        ));
    }
}
