//! Meshes that were refined, onto the wire.

use signorini::adapted::{AdaptionError, End, GoalRound, Round};
use signorini::report::Termination;
use signorini::scene::{SceneError, Violation};
use signorini_proto::v1 as wire;

use super::wide;
use crate::fault::Fault;

/// What a mesh gave.
pub(crate) fn round(round: &Round) -> wire::RefinementRound {
    wire::RefinementRound {
        round: i32::try_from(round.round).unwrap_or(i32::MAX),
        cell_count: wide(round.cells),
        unknown_count: wide(round.unknowns),
        goals: round.goals.iter().map(goal).collect(),
        seconds: round.seconds,
        dual_seconds: round.dual_seconds,
    }
}

fn goal(goal: &GoalRound) -> wire::RefinementGoal {
    wire::RefinementGoal {
        goal: goal.goal.clone(),
        value: goal.value,
        bound: goal.bound,
        estimate: goal.estimate,
        geometry: goal.geometry,
        tolerance: goal.tolerance,
    }
}

/// Why a mesh is not refined further.
pub(crate) fn end(end: &End) -> wire::RefinementEnd {
    match end {
        End::Reached => wire::RefinementEnd::Reached,
        End::Unknowns { .. } => wire::RefinementEnd::MaxUnknowns,
        End::Memory { .. } => wire::RefinementEnd::MaxMemory,
        End::NoRoom { .. } => wire::RefinementEnd::NoRoom,
        End::Time { .. } => wire::RefinementEnd::MaxTime,
        End::Rounds(_) => wire::RefinementEnd::MaxRounds,
        End::Facets { .. } => wire::RefinementEnd::Facets,
        End::Solver { .. } => wire::RefinementEnd::Solver,
        End::Zero(_) => wire::RefinementEnd::Zero,
        End::NoEquilibrium { .. } | End::NotConverged(_) => wire::RefinementEnd::NotConverged,
        End::Failed(_) => wire::RefinementEnd::Failed,
    }
}

/// Why there is no refined mesh at all.
pub(crate) fn fault(error: AdaptionError) -> Fault {
    let text = error.to_string();
    match error {
        AdaptionError::Scene(error) => error.into(),
        AdaptionError::Goal(_) | AdaptionError::Malformed(_) => {
            let path = "accuracy".to_owned();
            let message = text.trim_start_matches("accuracy: ").to_owned();
            SceneError::Invalid(vec![Violation { path, message }]).into()
        }
        AdaptionError::Stopped(Termination::DeadlineExceeded) => Fault::StreamDeadline,
        AdaptionError::Prepare(_)
        | AdaptionError::Refinement(_)
        | AdaptionError::NotCarried(_)
        | AdaptionError::Stopped(_)
        | _ => Fault::RefinementFailed(text),
    }
}
