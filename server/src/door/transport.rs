//! What the transport refuses before a request reaches its handler, in the words
//! of the contract: too large a message, and bytes that are no message.

use std::sync::Arc;

use tonic::{Code, Status};
use tonic_types::StatusExt as _;

use super::layer::{Answer, AroundCall, Reply, Request};
use super::refusal;
use crate::fault::Fault;
use crate::process::limits::MESSAGE_BYTES;
use crate::watch::metrics::Metrics;

/// The fault behind a status that the transport made while it read a request;
/// `None` for a broken connection and for statuses of this service.
pub(crate) fn fault_of(status: &Status) -> Option<Fault> {
    if !status.details().is_empty() {
        return None;
    }
    match status.code() {
        Code::OutOfRange => Some(Fault::MessageLimit {
            what: "bytes in one message".to_owned(),
            limit: MESSAGE_BYTES as u64,
        }),
        Code::Internal => Some(Fault::request("message", status.message())),
        Code::Ok
        | Code::Cancelled
        | Code::Unknown
        | Code::InvalidArgument
        | Code::DeadlineExceeded
        | Code::NotFound
        | Code::AlreadyExists
        | Code::PermissionDenied
        | Code::ResourceExhausted
        | Code::FailedPrecondition
        | Code::Aborted
        | Code::Unimplemented
        | Code::Unavailable
        | Code::DataLoss
        | Code::Unauthenticated => None,
    }
}

/// As [`fault_of`] for a stream that was read in part: also the fault with which the gate
/// before the transport refused one of its messages.
pub(crate) fn fault_of_stream(status: &Status) -> Option<Fault> {
    let Some(info) = status.get_details_error_info() else {
        return fault_of(status);
    };
    let text = |key: &str| info.metadata.get(key).cloned().unwrap_or_default();
    let number = |key: &str| text(key).parse().unwrap_or(0);
    match info.reason.as_str() {
        "MESSAGE_LIMIT" => Some(Fault::MessageLimit {
            what: text("what"),
            limit: number("limit"),
        }),
        "MEMORY_BUDGET" => Some(Fault::MemoryBudget {
            predicted: number("predicted_bytes"),
            held: number("held_bytes"),
            budget: number("budget_bytes"),
        }),
        _ => Some(Fault::request("message", status.message())),
    }
}

/// Gives refusals by the transport their reason, and counts them.
#[derive(Clone)]
pub(crate) struct GiveReasons(pub(crate) Arc<Metrics>);

impl AroundCall for GiveReasons {
    fn call<F: Reply>(&self, request: Request, inner: impl FnOnce(Request) -> F) -> Answer {
        let (answer, metrics) = (inner(request), Arc::clone(&self.0));
        Box::pin(async move {
            let response = answer.await?;
            // A status in the headers: nothing else was answered.
            let status = Status::from_header_map(response.headers());
            let Some(fault) = status.as_ref().and_then(fault_of) else {
                return Ok(response);
            };
            refusal::record(&metrics, &fault);
            Ok(Status::from(fault).into_http())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statuses_of_the_service_and_broken_connections_stay_as_they_are() {
        let own = Status::from(Fault::SequenceGap {
            received: 3,
            expected: 2,
        });
        assert_eq!(own.code(), Code::OutOfRange);
        assert_eq!(fault_of(&own), None);
        assert_eq!(fault_of(&Status::from(Fault::Internal)), None);
        assert_eq!(fault_of(&Status::cancelled("the client is gone")), None);
    }

    #[test]
    fn what_the_gate_refused_in_a_stream_is_known_again() {
        let limit = Fault::MessageLimit {
            what: "bytes".to_owned(),
            limit: 7,
        };
        let memory = Fault::MemoryBudget {
            predicted: 1,
            held: 2,
            budget: 3,
        };
        for fault in [limit, memory] {
            let status = Status::from(fault.clone());
            assert_eq!(fault_of_stream(&status), Some(fault));
        }
    }
}
