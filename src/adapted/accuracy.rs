//! What is asked for, and how far the loop may go.

use crate::scene::{Goal, GoalErrors, GoalQuestions};

/// Rounds where nobody says how many: each halves cells, so that they are a millionth in size; chosen.
const ROUNDS: u32 = 20;

/// A goal and how well it shall be known.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// The functional.
    pub goal: Goal,
    /// Largest error over the absolute value, above zero.
    pub tolerance: f64,
}

/// Limits of the loop; the mesh that came with the scene is solved in any case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccuracyLimits {
    /// Most unknowns of a mesh; none where any number will do.
    pub unknowns: Option<u64>,
    /// Most bytes that a plan may predict; none where any number will do.
    pub bytes: Option<u64>,
    /// Wall seconds that shall not be passed, by a forecast from the last round.
    pub seconds: Option<f64>,
    /// Most meshes, the first one counted.
    pub rounds: u32,
}

impl Default for AccuracyLimits {
    fn default() -> Self {
        Self {
            unknowns: None,
            bytes: None,
            seconds: None,
            rounds: ROUNDS,
        }
    }
}

/// What is asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Accuracy {
    /// Goals; all are to be known well enough.
    pub targets: Vec<Target>,
    /// How far the loop may go.
    pub limits: AccuracyLimits,
}

impl Accuracy {
    /// The goals with their errors, as a question.
    pub(super) fn questions(&self) -> GoalQuestions {
        GoalQuestions {
            goals: self.targets.iter().map(|one| one.goal.clone()).collect(),
            errors: GoalErrors::Bounded,
            ..GoalQuestions::default()
        }
    }
}
