//! The contract of statuses, for every fault.

use tonic_types::StatusExt;

use super::*;
use crate::fault::{FailureCause, violation};

fn damaged(kind: UploadKind, text: String) -> Fault {
    Fault::UploadDamaged {
        kind,
        name: text.clone(),
        why: text,
    }
}

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
        Fault::MeshInUse { .. } => Fault::RefinementFailed(text),
        Fault::RefinementFailed(_) => Fault::SurfaceInvalid(text),
        Fault::SurfaceInvalid(_) => Fault::SurfaceNotFound(text),
        Fault::SurfaceNotFound(_) => Fault::SurfaceInUse(text),
        Fault::SurfaceInUse(_) => Fault::SessionNotFound(text),
        Fault::SessionNotFound(_) => Fault::SessionElsewhere {
            name: text.clone(),
            owner: text,
        },
        Fault::SessionElsewhere { .. } => Fault::SessionExpired(text),
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
        Fault::StepNotFound { .. } => Fault::EventNotFound {
            name: text,
            seen: sequence,
            newest: sequence,
        },
        Fault::EventNotFound { .. } => Fault::SequenceGap {
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
        Fault::StreamDeadline => Fault::StreamUnread { seconds: u64::MAX },
        Fault::StreamUnread { .. } => Fault::ShuttingDown,
        Fault::ShuttingDown => Fault::Interrupted,
        Fault::Interrupted => Fault::Unwritable(text),
        Fault::Unwritable(_) => Fault::SessionDamaged {
            name: text.clone(),
            why: text,
        },
        Fault::SessionDamaged { .. } => damaged(UploadKind::Mesh, text),
        Fault::UploadDamaged { kind, .. } => match kind {
            UploadKind::Mesh => damaged(UploadKind::Surface, text),
            UploadKind::Surface => damaged(UploadKind::State, text),
            UploadKind::State => Fault::StateNotFound(text),
        },
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
