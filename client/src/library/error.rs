//! What can go wrong between a client and the service, typed by the reasons of
//! the service's contract.

use std::collections::BTreeMap;
use std::error::Error as _;
use std::fmt;
use std::time::Duration;

use signorini_proto::array::ArrayError;
use tonic::Code;
use tonic_types::{ErrorDetails, RpcStatusExt, StatusExt as _};

/// One fault of a scene, with the path of its key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// Such as `material.body.poisson_ratio`.
    pub path: String,
    /// What is wrong and what would be right.
    pub message: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.path.is_empty() {
            return out.write_str(&self.message);
        }
        write!(out, "{}: {}", self.path, self.message)
    }
}

/// An answer of the service that says no.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Canonical code.
    pub code: Code,
    /// Reason of the contract, such as `SCENE_INVALID`; empty when the answer
    /// does not come from the service itself.
    pub reason: String,
    /// For people.
    pub message: String,
    /// Whatever is variable in the message, by name.
    pub metadata: BTreeMap<String, String>,
    /// Keys of a scene that are wrong.
    pub violations: Vec<Violation>,
}

impl fmt::Display for Refusal {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.message)?;
        if !self.reason.is_empty() {
            write!(out, " ({})", self.reason)?;
        }
        Ok(())
    }
}

impl From<&tonic::Status> for Refusal {
    fn from(status: &tonic::Status) -> Self {
        Self::new(status.code(), status.message(), &status.get_error_details())
    }
}

impl From<&tonic_types::Status> for Refusal {
    fn from(status: &tonic_types::Status) -> Self {
        let details = RpcStatusExt::get_error_details(status);
        Self::new(Code::from_i32(status.code), &status.message, &details)
    }
}

impl Refusal {
    fn new(code: Code, message: &str, details: &ErrorDetails) -> Self {
        let info = details.error_info();
        let request = details.bad_request();
        let violations = request.map(|request| request.field_violations.as_slice());
        let violation = |violation: &tonic_types::FieldViolation| Violation {
            path: violation.field.clone(),
            message: violation.description.clone(),
        };
        Self {
            code,
            reason: info.map(|info| info.reason.clone()).unwrap_or_default(),
            message: message.to_owned(),
            metadata: info
                .map(|info| info.metadata.clone().into_iter().collect())
                .unwrap_or_default(),
            violations: violations
                .unwrap_or_default()
                .iter()
                .map(violation)
                .collect(),
        }
    }
}

/// Why a call did not give its result.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// An address that is neither a URL nor a socket path.
    #[error(
        "\"{0}\" is no server address: HOST:PORT, http://HOST:PORT, https://HOST:PORT or \
         unix:PATH is expected"
    )]
    Address(String),
    /// A text that cannot be a token.
    #[error("what was given as the token is no single word")]
    Token,
    /// Nothing says whose certificates are to be trusted.
    #[error(
        "{0} shows a certificate, but no authority is known: give --ca FILE or SIGNORINI_CA \
         (`ca.pem` of `signorini certs init`, or the bundle of the system)"
    )]
    NoAuthority(String),
    /// A token would travel readable through a network.
    #[error("a token is not sent to {0}: other machines could read it; use https://HOST:PORT")]
    Readable(String),
    /// Nobody answers at the address.
    #[error("no server answers at {address}: {message}")]
    Unreachable {
        /// As it was given.
        address: String,
        /// From the system.
        message: String,
    },
    /// What answers at the address is a proxy, and no server is behind it.
    #[error("a proxy answers, and no server behind it: {message}")]
    Gateway {
        /// What it said, or left of the call.
        message: String,
    },
    /// The service says no.
    #[error("{0}")]
    Refused(Box<Refusal>),
    /// The answer does not keep to the protocol.
    #[error("the server's answer breaks the protocol: {0}")]
    Protocol(String),
    /// An array that does not fit its announcement.
    #[error("the server sent a malformed array: {0}")]
    Array(#[from] ArrayError),
    /// A mesh with more items than the wire format can count.
    #[error("the mesh has {0} items of one kind, more than the service takes")]
    MeshTooLarge(usize),
    /// The connection broke and no other took its place within the patience.
    #[error("the connection to the server broke: {message}")]
    Broken {
        /// What happened last.
        message: String,
    },
    /// The server holds the connection and does not answer.
    #[error("the server does not answer within {} s", .0.as_secs())]
    Silent(Duration),
    /// The server came back without the session: it was restarted.
    #[error(
        "the server was restarted, or somebody deleted the session meanwhile: it has no \
         \"{0}\" any more; results so far are kept, solve again for the others"
    )]
    SessionLost(String),
    /// Results that came during a break are no longer kept.
    #[error("results {first} to {last} are lost: the server no longer keeps them")]
    ResultsLost {
        /// Event number of the first.
        first: i64,
        /// Event number of the last.
        last: i64,
    },
    /// The stream has ended; nothing can be sent.
    #[error("the stream to the server has ended")]
    Closed,
}

/// A call that failed without an answer; travels as the source of a status.
#[derive(Clone, Debug, thiserror::Error)]
#[error("no server answers at {address}: {message}")]
pub(crate) struct Unanswered {
    pub(crate) address: String,
    pub(crate) message: String,
    pub(crate) stage: Stage,
}

/// How far a call came that has no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Not to the end of the connection, or that ended.
    Connection,
    /// To somebody who gave the call up and kept the connection, as proxies do.
    Call,
}

/// Whether a status without a reason comes from something between here and the service; a call
/// that this side cancels gives no status at all.
pub(crate) fn is_of_gateway(status: &tonic::Status) -> bool {
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

impl From<tonic::Status> for ClientError {
    fn from(status: tonic::Status) -> Self {
        let source = status.source();
        if let Some(unanswered) = source.and_then(|source| source.downcast_ref::<Unanswered>()) {
            let Unanswered {
                address,
                message,
                stage,
            } = unanswered.clone();
            return match stage {
                Stage::Connection => Self::Unreachable { address, message },
                Stage::Call => Self::Gateway { message },
            };
        }
        let refusal = Refusal::from(&status);
        if refusal.reason.is_empty() && is_of_gateway(&status) {
            let message = status.message().to_owned();
            return Self::Gateway { message };
        }
        Self::Refused(Box::new(refusal))
    }
}

impl ClientError {
    /// The same refusal, saying which file it is about.
    #[must_use]
    pub fn about(mut self, path: &std::path::Path) -> Self {
        if let Self::Refused(refusal) = &mut self {
            refusal.message = format!("{}: {}", path.display(), refusal.message);
        }
        self
    }

    /// The service's answer, if it is one.
    pub fn refusal(&self) -> Option<&Refusal> {
        match self {
            Self::Refused(refusal) => Some(refusal),
            Self::Address(_)
            | Self::Token
            | Self::NoAuthority(_)
            | Self::Readable(_)
            | Self::Unreachable { .. }
            | Self::Gateway { .. }
            | Self::Protocol(_)
            | Self::Array(_)
            | Self::MeshTooLarge(_)
            | Self::Broken { .. }
            | Self::Silent(_)
            | Self::SessionLost(_)
            | Self::ResultsLost { .. }
            | Self::Closed => None,
        }
    }

    /// Whether the service says no for this reason of its contract.
    pub fn is_reason(&self, reason: &str) -> bool {
        self.refusal()
            .is_some_and(|refusal| refusal.reason == reason)
    }
}
