//! From a [`Fault`] to `google.rpc.Status`: the only place that makes one.
//!
//! Every status carries an `ErrorInfo` whose reason is part of the contract.
//! Statuses travel in HTTP/2 trailers, so each is kept below [`LIMIT_BYTES`]:
//! at most [`MAXIMUM_VIOLATIONS`] violations, long texts cut.

mod metadata;
#[cfg(test)]
mod tests;

use prost::Message as _;
use prost_types::Any;
use signorini::scene::Violation;
use tonic::Code;
use tonic_types::pb;

use crate::fault::retry;
use crate::fault::{Fault, UploadKind};
use metadata::metadata;

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
pub(crate) const REASONS: [&str; 40] = [
    "SCENE_INVALID",
    "UNSUPPORTED_COMBINATION",
    "REQUEST_INVALID",
    "MESH_INVALID",
    "MESH_DIGEST_MISMATCH",
    "MESH_NOT_FOUND",
    "MESH_IN_USE",
    "REFINEMENT_FAILED",
    "SURFACE_INVALID",
    "SURFACE_NOT_FOUND",
    "SURFACE_IN_USE",
    "SESSION_NOT_FOUND",
    "SESSION_ELSEWHERE",
    "SESSION_EXPIRED",
    "SESSION_EXISTS",
    "SESSION_BUSY",
    "SESSION_DELETED",
    "SESSION_FAILED",
    "STEP_NOT_FOUND",
    "EVENT_NOT_FOUND",
    "SEQUENCE_GAP",
    "SEQUENCE_NOT_RETAINED",
    "MEMORY_BUDGET",
    "QUEUE_FULL",
    "SESSION_LIMIT",
    "CALL_RATE",
    "MESSAGE_LIMIT",
    "STREAM_DEADLINE",
    "STREAM_UNREAD",
    "SHUTTING_DOWN",
    "DATA_UNWRITABLE",
    "SESSION_DAMAGED",
    "MESH_DAMAGED",
    "SURFACE_DAMAGED",
    "STATE_DAMAGED",
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
        Fault::RefinementFailed(_) => (Code::Aborted, "REFINEMENT_FAILED"),
        Fault::SurfaceInvalid(_) => (Code::InvalidArgument, "SURFACE_INVALID"),
        Fault::SurfaceNotFound(_) => (Code::NotFound, "SURFACE_NOT_FOUND"),
        Fault::SurfaceInUse(_) => (Code::FailedPrecondition, "SURFACE_IN_USE"),
        Fault::SessionNotFound(_) => (Code::NotFound, "SESSION_NOT_FOUND"),
        Fault::SessionElsewhere { .. } => (Code::Unavailable, "SESSION_ELSEWHERE"),
        Fault::SessionExpired(_) => (Code::NotFound, "SESSION_EXPIRED"),
        Fault::SessionExists(_) => (Code::AlreadyExists, "SESSION_EXISTS"),
        Fault::SessionBusy { .. } => (Code::Aborted, "SESSION_BUSY"),
        Fault::SessionDeleted(_) => (Code::Aborted, "SESSION_DELETED"),
        Fault::SessionFailed { .. } => (Code::FailedPrecondition, "SESSION_FAILED"),
        Fault::StepNotFound { .. } => (Code::NotFound, "STEP_NOT_FOUND"),
        Fault::EventNotFound { .. } => (Code::OutOfRange, "EVENT_NOT_FOUND"),
        Fault::SequenceGap { .. } => (Code::OutOfRange, "SEQUENCE_GAP"),
        Fault::SequenceNotRetained { .. } => (Code::OutOfRange, "SEQUENCE_NOT_RETAINED"),
        Fault::MemoryBudget { .. } => (Code::ResourceExhausted, "MEMORY_BUDGET"),
        Fault::QueueFull { .. } => (Code::ResourceExhausted, "QUEUE_FULL"),
        Fault::SessionLimit { .. } => (Code::ResourceExhausted, "SESSION_LIMIT"),
        Fault::CallRate { .. } => (Code::ResourceExhausted, "CALL_RATE"),
        Fault::MessageLimit { .. } => (Code::ResourceExhausted, "MESSAGE_LIMIT"),
        Fault::StreamDeadline => (Code::DeadlineExceeded, "STREAM_DEADLINE"),
        Fault::StreamUnread { .. } => (Code::Unavailable, "STREAM_UNREAD"),
        Fault::ShuttingDown => (Code::Unavailable, "SHUTTING_DOWN"),
        Fault::Interrupted => (Code::Unavailable, "SHUTTING_DOWN"),
        Fault::Unwritable(_) => (Code::Unavailable, "DATA_UNWRITABLE"),
        Fault::SessionDamaged { .. } => (Code::DataLoss, "SESSION_DAMAGED"),
        Fault::UploadDamaged { kind, .. } => (Code::DataLoss, damaged(*kind)),
        Fault::StateNotFound(_) => (Code::NotFound, "STATE_NOT_FOUND"),
        Fault::StateInvalid(_) => (Code::InvalidArgument, "STATE_INVALID"),
        Fault::Unauthenticated => (Code::Unauthenticated, "UNAUTHENTICATED"),
        Fault::PermissionDenied { .. } => (Code::PermissionDenied, "PERMISSION_DENIED"),
        Fault::Internal => (Code::Internal, "INTERNAL"),
    }
}

fn damaged(kind: UploadKind) -> &'static str {
    match kind {
        UploadKind::Mesh => "MESH_DAMAGED",
        UploadKind::Surface => "SURFACE_DAMAGED",
        UploadKind::State => "STATE_DAMAGED",
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
            | Fault::SessionElsewhere { .. }
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
