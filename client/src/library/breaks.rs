//! Whether the end of a call is the service's will or the fault of what lies between; what was
//! broken is tried again.
//!
//! A stream goes on by itself (see [`crate::library::solve`]). Other calls are made again when something
//! between here and the service says that nobody is behind it, or the service says that the session
//! goes on elsewhere or later. What reaches nobody at all fails at once.

use std::error::Error as _;
use std::time::{Duration, Instant};

use tonic::Status;

use crate::library::backoff::Backoff;
use crate::library::connect::root_cause;
use crate::library::error::{ClientError, Refusal, Unanswered, is_of_gateway};

/// How long a call is made again.
const PATIENCE: Duration = Duration::from_secs(30);
/// Connections of a call that nobody answers.
const CONNECTIONS: u32 = 2;

/// Why no answer follows.
#[derive(Debug)]
pub(crate) enum Stop {
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
        match status.source() {
            Some(source) if source.is::<Unanswered>() => Self::Broken(status.into()),
            Some(source) => broken(root_cause(source)),
            None if resumes(&refusal) || gateway => Self::Broken(status.into()),
            None => Self::Fault(status.into()),
        }
    }
}

/// Whether the session goes on later, or at another server: it is in the data folder of a server
/// that is being restarted or whose disk is full, or in a fleet.
fn resumes(refusal: &Refusal) -> bool {
    let resumes = refusal.metadata.get("resumes");
    resumes.is_some_and(|value| value == "true")
}

impl From<Stop> for ClientError {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::Broken(error) | Stop::Fault(error) => error,
        }
    }
}

pub(crate) fn broken(message: String) -> Stop {
    Stop::Broken(ClientError::Broken { message })
}

/// The answer to a call that may be made any number of times.
///
/// # Errors
/// The last failure once the patience is used up; at once for what the service says, and where
/// nothing answers, not even on a connection made anew: one that was there may have ended unseen.
pub(crate) async fn again<T, Answer>(mut call: impl FnMut() -> Answer) -> Result<T, ClientError>
where
    Answer: Future<Output = Result<T, ClientError>>,
{
    let mut backoff = Backoff::new(PATIENCE, Instant::now());
    let mut connections = 1;
    loop {
        let error = match call().await {
            Ok(answer) => return Ok(answer),
            Err(error) => error,
        };
        let is_unreachable = matches!(error, ClientError::Unreachable { .. });
        if is_unreachable && connections < CONNECTIONS {
            connections += 1;
            continue;
        }
        let pause = backoff.pause(Instant::now());
        match pause.filter(|_| is_passing(&error)) {
            Some(pause) => tokio::time::sleep(pause).await,
            None => return Err(error),
        }
    }
}

/// Whether the next try may reach the service, or the session.
fn is_passing(error: &ClientError) -> bool {
    match error {
        ClientError::Refused(refusal) => resumes(refusal),
        ClientError::Gateway { .. } => true,
        ClientError::Address(_)
        | ClientError::Token
        | ClientError::NoAuthority(_)
        | ClientError::Readable(_)
        | ClientError::Unreachable { .. }
        | ClientError::Protocol(_)
        | ClientError::Array(_)
        | ClientError::MeshTooLarge(_)
        | ClientError::Broken { .. }
        | ClientError::Silent(_)
        | ClientError::SessionLost(_)
        | ClientError::ResultsLost { .. }
        | ClientError::Closed => false,
    }
}

#[cfg(test)]
mod tests {
    use std::io;

    use tonic::Code;
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
