//! From a [`Fault`] to `google.rpc.Status`: the only place that makes one.
//!
//! Every status carries an `ErrorInfo` whose reason is part of the contract.
//! Statuses travel in HTTP/2 trailers, so each is kept below [`LIMIT_BYTES`]:
//! at most [`MAXIMUM_VIOLATIONS`] violations, long texts cut.

use prost::Message as _;
use prost_types::Any;
use signorini::scene::Violation;
use tonic::Code;
use tonic_types::pb;

use crate::fault::{FailureCause, Fault};
use crate::retry;

/// Encoded size that no status reaches.
const LIMIT_BYTES: usize = 4096;
/// Violations in one status; the message counts the rest.
const MAXIMUM_VIOLATIONS: usize = 20;
const MAXIMUM_TEXT: usize = 600;
const DOMAIN: &str = "signorini";
const TYPE_PREFIX: &str = "type.googleapis.com/google.rpc.";

impl From<Fault> for tonic::Status {
    fn from(fault: Fault) -> Self {
        let status = rpc_status(&fault);
        let details = status.encode_to_vec().into();
        Self::with_details(Code::from_i32(status.code), status.message, details)
    }
}

/// The reason of `fault`: one of a fixed set.
pub(crate) fn reason(fault: &Fault) -> &'static str {
    contract(fault).1
}

/// Every reason, in the order of the faults.
pub(crate) const REASONS: [&str; 33] = [
    "SCENE_INVALID",
    "UNSUPPORTED_COMBINATION",
    "REQUEST_INVALID",
    "MESH_INVALID",
    "MESH_DIGEST_MISMATCH",
    "MESH_NOT_FOUND",
    "MESH_IN_USE",
    "SURFACE_INVALID",
    "SURFACE_NOT_FOUND",
    "SURFACE_IN_USE",
    "SESSION_NOT_FOUND",
    "SESSION_EXPIRED",
    "SESSION_EXISTS",
    "SESSION_BUSY",
    "SESSION_DELETED",
    "SESSION_FAILED",
    "STEP_NOT_FOUND",
    "SEQUENCE_GAP",
    "SEQUENCE_NOT_RETAINED",
    "MEMORY_BUDGET",
    "QUEUE_FULL",
    "SESSION_LIMIT",
    "CALL_RATE",
    "MESSAGE_LIMIT",
    "STREAM_DEADLINE",
    "SHUTTING_DOWN",
    "DATA_UNWRITABLE",
    "SESSION_DAMAGED",
    "STATE_NOT_FOUND",
    "STATE_INVALID",
    "UNAUTHENTICATED",
    "PERMISSION_DENIED",
    "INTERNAL",
];

/// What `fault` says, no longer than a log can bear: clients choose the names in it.
pub(crate) fn text(fault: &Fault) -> String {
    shortened(&fault.to_string())
}

/// As much of a client's text as an answer or the log takes.
pub(crate) fn shortened(text: &str) -> String {
    cut(text, MAXIMUM_TEXT)
}

/// The status of `fault` with all its details.
pub(crate) fn rpc_status(fault: &Fault) -> pb::Status {
    let (code, reason) = contract(fault);
    let entry = |(key, value): (&str, String)| (key.to_owned(), cut(&value, MAXIMUM_TEXT));
    let info = pb::ErrorInfo {
        reason: reason.to_owned(),
        domain: DOMAIN.to_owned(),
        metadata: metadata(fault).into_iter().map(entry).collect(),
    };
    let mut status = pb::Status {
        code: code.into(),
        message: text(fault),
        details: vec![any("ErrorInfo", &info)],
    };
    status.details.extend(resource_info(fault));
    status.details.extend(retry_info(fault));
    add_violations(&mut status, violations(fault));
    status
}

fn contract(fault: &Fault) -> (Code, &'static str) {
    match fault {
        Fault::SceneInvalid(_) => (Code::InvalidArgument, "SCENE_INVALID"),
        Fault::Unsupported(_) => (Code::Unimplemented, "UNSUPPORTED_COMBINATION"),
        Fault::RequestInvalid(_) => (Code::InvalidArgument, "REQUEST_INVALID"),
        Fault::MeshInvalid(_) => (Code::InvalidArgument, "MESH_INVALID"),
        Fault::DigestMismatch { .. } => (Code::InvalidArgument, "MESH_DIGEST_MISMATCH"),
        Fault::MeshNotFound(_) => (Code::NotFound, "MESH_NOT_FOUND"),
        Fault::MeshInUse { .. } => (Code::FailedPrecondition, "MESH_IN_USE"),
        Fault::SurfaceInvalid(_) => (Code::InvalidArgument, "SURFACE_INVALID"),
        Fault::SurfaceNotFound(_) => (Code::NotFound, "SURFACE_NOT_FOUND"),
        Fault::SurfaceInUse(_) => (Code::FailedPrecondition, "SURFACE_IN_USE"),
        Fault::SessionNotFound(_) => (Code::NotFound, "SESSION_NOT_FOUND"),
        Fault::SessionExpired(_) => (Code::NotFound, "SESSION_EXPIRED"),
        Fault::SessionExists(_) => (Code::AlreadyExists, "SESSION_EXISTS"),
        Fault::SessionBusy { .. } => (Code::Aborted, "SESSION_BUSY"),
        Fault::SessionDeleted(_) => (Code::Aborted, "SESSION_DELETED"),
        Fault::SessionFailed { .. } => (Code::FailedPrecondition, "SESSION_FAILED"),
        Fault::StepNotFound { .. } => (Code::NotFound, "STEP_NOT_FOUND"),
        Fault::SequenceGap { .. } => (Code::OutOfRange, "SEQUENCE_GAP"),
        Fault::SequenceNotRetained { .. } => (Code::OutOfRange, "SEQUENCE_NOT_RETAINED"),
        Fault::MemoryBudget { .. } => (Code::ResourceExhausted, "MEMORY_BUDGET"),
        Fault::QueueFull { .. } => (Code::ResourceExhausted, "QUEUE_FULL"),
        Fault::SessionLimit { .. } => (Code::ResourceExhausted, "SESSION_LIMIT"),
        Fault::CallRate { .. } => (Code::ResourceExhausted, "CALL_RATE"),
        Fault::MessageLimit { .. } => (Code::ResourceExhausted, "MESSAGE_LIMIT"),
        Fault::StreamDeadline => (Code::DeadlineExceeded, "STREAM_DEADLINE"),
        Fault::ShuttingDown => (Code::Unavailable, "SHUTTING_DOWN"),
        Fault::Interrupted => (Code::Unavailable, "SHUTTING_DOWN"),
        Fault::Unwritable(_) => (Code::Unavailable, "DATA_UNWRITABLE"),
        Fault::SessionDamaged { .. } => (Code::DataLoss, "SESSION_DAMAGED"),
        Fault::StateNotFound(_) => (Code::NotFound, "STATE_NOT_FOUND"),
        Fault::StateInvalid(_) => (Code::InvalidArgument, "STATE_INVALID"),
        Fault::Unauthenticated => (Code::Unauthenticated, "UNAUTHENTICATED"),
        Fault::PermissionDenied { .. } => (Code::PermissionDenied, "PERMISSION_DENIED"),
        Fault::Internal => (Code::Internal, "INTERNAL"),
    }
}

/// Everything variable in the message, by name.
fn metadata(fault: &Fault) -> Vec<(&'static str, String)> {
    match fault {
        Fault::SceneInvalid(all) => vec![("violation_count", all.len().to_string())],
        Fault::Unsupported(one) | Fault::RequestInvalid(one) => vec![("path", one.path.clone())],
        Fault::DigestMismatch { declared, computed } => {
            vec![
                ("declared", declared.clone()),
                ("computed", computed.clone()),
            ]
        }
        Fault::MeshNotFound(name) => vec![("mesh", name.clone())],
        Fault::MeshInUse { sessions, .. } => vec![("sessions", sessions.to_string())],
        Fault::SurfaceNotFound(name) | Fault::SurfaceInUse(name) => {
            vec![("surface", name.clone())]
        }
        Fault::SessionNotFound(name)
        | Fault::SessionExpired(name)
        | Fault::SessionExists(name)
        | Fault::SessionDeleted(name)
        | Fault::SessionDamaged { name, .. } => vec![("session", name.clone())],
        Fault::SessionFailed { name, cause, .. } => {
            let memory = matches!(cause, FailureCause::Memory);
            let cause = memory.then(|| ("cause", "memory".to_owned()));
            let session = ("session", name.clone());
            std::iter::once(session).chain(cause).collect()
        }
        Fault::StateNotFound(name) => vec![("state", name.clone())],
        Fault::Interrupted | Fault::Unwritable(_) => vec![("resumes", "true".to_owned())],
        Fault::SessionBusy { held_since, .. } => vec![("held_since", held_since.to_string())],
        Fault::StepNotFound { sequence, .. } => vec![("sequence", sequence.to_string())],
        Fault::SequenceGap { expected, .. } => vec![("expected", expected.to_string())],
        Fault::SequenceNotRetained { first, .. } => vec![("first", first.to_string())],
        Fault::MemoryBudget {
            predicted,
            held,
            budget,
        } => vec![
            ("predicted_bytes", predicted.to_string()),
            ("held_bytes", held.to_string()),
            ("budget_bytes", budget.to_string()),
        ],
        Fault::QueueFull { limit } | Fault::SessionLimit { limit } => {
            vec![("limit", limit.to_string())]
        }
        Fault::CallRate { limit } => vec![("limit", limit.to_string())],
        Fault::MessageLimit { what, limit } => {
            vec![("what", what.clone()), ("limit", limit.to_string())]
        }
        Fault::PermissionDenied { role, needed } => vec![
            ("role", (*role).to_owned()),
            ("needed", (*needed).to_owned()),
        ],
        Fault::MeshInvalid(_)
        | Fault::SurfaceInvalid(_)
        | Fault::Unauthenticated
        | Fault::StreamDeadline
        | Fault::ShuttingDown
        | Fault::StateInvalid(_)
        | Fault::Internal => Vec::new(),
    }
}

fn violations(fault: &Fault) -> &[Violation] {
    if let Fault::SceneInvalid(all) = fault {
        return all;
    }
    if let Fault::RequestInvalid(one) | Fault::Unsupported(one) = fault {
        return std::slice::from_ref(one);
    }
    &[]
}

/// Adds as many violations as fit.
fn add_violations(status: &mut pb::Status, all: &[Violation]) {
    let field = |one: &Violation| pb::bad_request::FieldViolation {
        field: cut(&one.path, MAXIMUM_TEXT / 2),
        description: cut(&one.message, MAXIMUM_TEXT / 2),
        ..Default::default()
    };
    let mut request = pb::BadRequest {
        field_violations: all.iter().take(MAXIMUM_VIOLATIONS).map(field).collect(),
    };
    while !request.field_violations.is_empty() {
        status.details.push(any("BadRequest", &request));
        // The text of the message travels a second time in its own header.
        if status.encoded_len() + status.message.len() < LIMIT_BYTES {
            return;
        }
        status.details.pop();
        request.field_violations.pop();
    }
}

fn resource_info(fault: &Fault) -> Option<Any> {
    let (kind, name) = if let Fault::MeshNotFound(name) = fault {
        ("mesh", name)
    } else if let Fault::SurfaceNotFound(name) = fault {
        ("surface", name)
    } else if let Fault::SessionNotFound(name) | Fault::SessionExpired(name) = fault {
        ("session", name)
    } else {
        return None;
    };
    let info = pb::ResourceInfo {
        resource_type: kind.to_owned(),
        resource_name: cut(name, MAXIMUM_TEXT),
        ..Default::default()
    };
    Some(any("ResourceInfo", &info))
}

fn retry_info(fault: &Fault) -> Option<Any> {
    let comes_again = matches!(
        fault,
        Fault::QueueFull { .. }
            | Fault::SessionLimit { .. }
            | Fault::CallRate { .. }
            | Fault::MemoryBudget { .. }
            | Fault::ShuttingDown
            | Fault::Interrupted
            | Fault::Unwritable(_)
    );
    if !comes_again {
        return None;
    }
    let delay = prost_types::Duration::try_from(retry::delay()).ok()?;
    let info = pb::RetryInfo {
        retry_delay: Some(delay),
    };
    Some(any("RetryInfo", &info))
}

fn any(name: &str, message: &impl prost::Message) -> Any {
    Any {
        type_url: format!("{TYPE_PREFIX}{name}"),
        value: message.encode_to_vec(),
    }
}

/// At most `limit` bytes of `text`, cut between characters.
fn cut(text: &str, limit: usize) -> String {
    if text.len() <= limit {
        return text.to_owned();
    }
    let end = (0..=limit)
        .rev()
        .find(|index| text.is_char_boundary(*index))
        .unwrap_or(0);
    format!("{}...", text.get(..end).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use tonic_types::StatusExt;

    use super::*;
    use crate::fault::violation;

    #[test]
    fn violations_travel_with_their_paths_and_the_rest_is_counted() {
        let all = (0..30)
            .map(|index| violation(format!("probe.p{index}"), "is outside"))
            .collect();
        let status = tonic::Status::from(Fault::SceneInvalid(all));
        let fields = status.get_details_bad_request().unwrap().field_violations;
        assert_eq!(fields.len(), MAXIMUM_VIOLATIONS);
        assert_eq!(fields[0].field, "probe.p0");
        let info = status.get_details_error_info().unwrap();
        assert_eq!(info.reason, "SCENE_INVALID");
        assert_eq!(info.metadata["violation_count"], "30");
        assert!(status.message().contains("29 more"));
    }

    /// The next kind of fault with the longest `text` it can carry: a walk through
    /// all of them that a new kind has to join.
    fn following(fault: &Fault, text: &str) -> Option<Fault> {
        let one = || violation(text, text);
        let text = text.to_owned();
        let (sequence, many) = (i64::MIN, usize::MAX);
        Some(match fault {
            Fault::SceneInvalid(_) => Fault::Unsupported(one()),
            Fault::Unsupported(_) => Fault::RequestInvalid(one()),
            Fault::RequestInvalid(_) => Fault::MeshInvalid(text),
            Fault::MeshInvalid(_) => Fault::DigestMismatch {
                declared: text.clone(),
                computed: text,
            },
            Fault::DigestMismatch { .. } => Fault::MeshNotFound(text),
            Fault::MeshNotFound(_) => Fault::MeshInUse {
                name: text,
                sessions: many,
            },
            Fault::MeshInUse { .. } => Fault::SurfaceInvalid(text),
            Fault::SurfaceInvalid(_) => Fault::SurfaceNotFound(text),
            Fault::SurfaceNotFound(_) => Fault::SurfaceInUse(text),
            Fault::SurfaceInUse(_) => Fault::SessionNotFound(text),
            Fault::SessionNotFound(_) => Fault::SessionExpired(text),
            Fault::SessionExpired(_) => Fault::SessionExists(text),
            Fault::SessionExists(_) => Fault::SessionBusy {
                name: text,
                held_since: u64::MAX,
            },
            Fault::SessionBusy { .. } => Fault::SessionDeleted(text),
            Fault::SessionDeleted(_) => Fault::SessionFailed {
                name: text.clone(),
                why: text,
                cause: FailureCause::Memory,
            },
            Fault::SessionFailed { .. } => Fault::StepNotFound {
                name: text,
                sequence,
            },
            Fault::StepNotFound { .. } => Fault::SequenceGap {
                received: sequence,
                expected: sequence,
            },
            Fault::SequenceGap { .. } => Fault::SequenceNotRetained {
                sequence,
                first: sequence,
            },
            Fault::SequenceNotRetained { .. } => Fault::MemoryBudget {
                predicted: u64::MAX,
                held: u64::MAX,
                budget: u64::MAX,
            },
            Fault::MemoryBudget { .. } => Fault::QueueFull { limit: many },
            Fault::QueueFull { .. } => Fault::SessionLimit { limit: many },
            Fault::SessionLimit { .. } => Fault::CallRate { limit: u32::MAX },
            Fault::CallRate { .. } => Fault::MessageLimit {
                what: text,
                limit: u64::MAX,
            },
            Fault::MessageLimit { .. } => Fault::StreamDeadline,
            Fault::StreamDeadline => Fault::ShuttingDown,
            Fault::ShuttingDown => Fault::Interrupted,
            Fault::Interrupted => Fault::Unwritable(text),
            Fault::Unwritable(_) => Fault::SessionDamaged {
                name: text.clone(),
                why: text,
            },
            Fault::SessionDamaged { .. } => Fault::StateNotFound(text),
            Fault::StateNotFound(_) => Fault::StateInvalid(text),
            Fault::StateInvalid(_) => Fault::Unauthenticated,
            Fault::Unauthenticated => Fault::PermissionDenied {
                role: "read",
                needed: "admin",
            },
            Fault::PermissionDenied { .. } => Fault::Internal,
            Fault::Internal => return None,
        })
    }

    /// Bytes of the two trailers: the message percent-encoded, the details in base 64.
    fn trailer_bytes(status: &pb::Status) -> usize {
        let plain = |byte: &&u8| (b' '..=b'~').contains(*byte) && **byte != b'%';
        let kept = status.message.as_bytes().iter().filter(plain).count();
        let escaped = status.message.len() - kept;
        kept + 3 * escaped + status.encoded_len().div_ceil(3) * 4
    }

    #[test]
    fn the_worst_case_of_every_fault_stays_below_the_trailer_limit() {
        // One to four bytes a character; the prefixes move the place of the cut.
        for letter in ["a", "ä", "\u{20ac}", "\u{1f9ca}", "\0"] {
            for prefix in ["", "b", "bb", "bbb"] {
                let text = format!("{prefix}{}", letter.repeat(10_000));
                let all = vec![violation(&*text, &*text); 100];
                let mut next = Some(Fault::SceneInvalid(all));
                while let Some(fault) = next {
                    let status = rpc_status(&fault);
                    let bytes = status.encoded_len() + status.message.len();
                    assert!(bytes < LIMIT_BYTES, "{}: {bytes}", reason(&fault));
                    let bytes = trailer_bytes(&status);
                    assert!(bytes < 2 * LIMIT_BYTES, "{}: {bytes}", reason(&fault));
                    let info = tonic::Status::from(fault.clone()).get_details_error_info();
                    assert_eq!(info.unwrap().reason, reason(&fault));
                    next = following(&fault, &text);
                }
            }
        }
    }

    #[test]
    fn ten_thousand_violations_of_any_length_fit() {
        for length in [1, 20, 100, 256, 300, 1000] {
            let text = "\u{20ac}".repeat(length);
            let fault = Fault::SceneInvalid(vec![violation(&*text, &*text); 10_000]);
            let status = rpc_status(&fault);
            let bytes = status.encoded_len() + status.message.len();
            assert!(bytes < LIMIT_BYTES, "{length}: {bytes}");
            let status = tonic::Status::from(fault);
            let request = status.get_details_bad_request().unwrap();
            assert!(!request.field_violations.is_empty(), "{length}");
            let info = status.get_details_error_info().unwrap();
            assert_eq!(info.metadata["violation_count"], "10000");
        }
    }

    #[test]
    fn the_list_of_reasons_is_that_of_the_faults() {
        let first = Fault::SceneInvalid(Vec::new());
        let all = std::iter::successors(Some(first), |fault| following(fault, ""));
        let mut reasons: Vec<_> = all.map(|fault| reason(&fault)).collect();
        // A shutdown has two texts.
        reasons.dedup();
        assert_eq!(reasons, REASONS);
    }

    #[test]
    fn only_transient_faults_ask_to_retry() {
        let full = tonic::Status::from(Fault::QueueFull { limit: 1 });
        assert!(full.get_details_retry_info().is_some());
        let missing = tonic::Status::from(Fault::MeshNotFound("meshes/0".into()));
        assert!(missing.get_details_retry_info().is_none());
        assert!(missing.get_details_resource_info().is_some());
    }
}
