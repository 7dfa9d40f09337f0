//! Faults of a scene, each with the path of the key it concerns.
//!
//! All faults of a scene are found in one pass and reported together, each with a message
//! that says what would be right.

/// One fault of a scene or step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// Path of the key, such as `material.body.poisson_ratio`.
    pub path: String,
    /// What is wrong and what would be right, as a sentence.
    pub message: String,
}

impl std::fmt::Display for Violation {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{}: {}", self.path, self.message)
    }
}

/// A scene or step that cannot be solved as written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// One or more keys are wrong; all faults are reported at once.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Invalid(Vec<Violation>),
    /// A key or combination that this version does not solve.
    #[error("not supported yet: {0}")]
    Unsupported(Violation),
}
