//! What varies in the message of a fault, by names that are part of the contract.

use crate::fault::{FailureCause, Fault};

/// Everything variable in the message, by name.
pub(super) fn metadata(fault: &Fault) -> Vec<(&'static str, String)> {
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
        Fault::SessionElsewhere { name, owner } => {
            let owner = Some(owner).filter(|owner| !owner.is_empty());
            let known = [
                ("session", name.clone()),
                // The session goes on where it is, or at the next server that is asked for it.
                ("resumes", "true".to_owned()),
            ];
            let owner = owner.map(|owner| ("owner", owner.clone()));
            known.into_iter().chain(owner).collect()
        }
        Fault::SessionFailed { name, cause, .. } => {
            let memory = matches!(cause, FailureCause::Memory);
            let cause = memory.then(|| ("cause", "memory".to_owned()));
            let session = ("session", name.clone());
            std::iter::once(session).chain(cause).collect()
        }
        Fault::UploadDamaged { kind, name, .. } => vec![(kind.name(), name.clone())],
        Fault::StateNotFound(name) => vec![("state", name.clone())],
        Fault::Interrupted | Fault::Unwritable(_) | Fault::StreamUnread { .. } => {
            vec![("resumes", "true".to_owned())]
        }
        Fault::SessionBusy { held_since, .. } => vec![("held_since", held_since.to_string())],
        Fault::StepNotFound { sequence, .. } => vec![("sequence", sequence.to_string())],
        Fault::EventNotFound { newest, .. } => vec![("newest", newest.to_string())],
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
        | Fault::RefinementFailed(_)
        | Fault::SurfaceInvalid(_)
        | Fault::Unauthenticated
        | Fault::StreamDeadline
        | Fault::ShuttingDown
        | Fault::StateInvalid(_)
        | Fault::Internal => Vec::new(),
    }
}
