//! Why there is no result.

use crate::goals::GoalError;
use crate::prepare::PrepareError;
use crate::refinement::RefinementError;
use crate::report::Termination;
use crate::scene::SceneError;
use crate::session::NotCarried;

/// Why there is no result at all.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AdaptionError {
    /// The scene or a step is faulty.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Nothing is asked for, or what no mesh has.
    #[error("accuracy: {0}")]
    Malformed(&'static str),
    /// The first mesh could not be prepared.
    #[error(transparent)]
    Prepare(#[from] PrepareError),
    /// A goal has no error.
    #[error("accuracy: {0}")]
    Goal(#[from] GoalError),
    /// The mesh cannot be refined.
    #[error(transparent)]
    Refinement(#[from] RefinementError),
    /// The state does not go over.
    #[error(transparent)]
    NotCarried(#[from] NotCarried),
    /// The caller stopped it.
    #[error("stopped while the mesh was refined ({})", .0.name())]
    Stopped(Termination),
}
