//! What is asked of increments beside their results, and of which of them: a load step is a number
//! of increments, whose last one is the end that the caller has named.

use super::Scene;
use super::goal::Goal;
use super::parameter::Parameter;

/// What is asked of increments that converge.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GoalQuestions {
    /// Functionals.
    pub goals: Vec<Goal>,
    /// What each is differentiated by.
    pub parameters: Vec<Parameter>,
    /// Whether the error of each is asked for.
    pub errors: GoalErrors,
    /// Of which increments of a step.
    pub at: AskedAt,
}

impl Scene {
    /// The first questions about errors; none where no error is asked for.
    pub(crate) fn bounded(&self) -> Option<&GoalQuestions> {
        let mut all = self.questions.iter();
        all.find(|one| one.errors == GoalErrors::Bounded)
    }
}

/// Of which increments of a step something is asked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AskedAt {
    /// Of the last one.
    #[default]
    Steps,
    /// Of all.
    Increments,
}

impl AskedAt {
    /// Whether it is asked of an increment.
    pub(crate) fn asks(self, place: InStep) -> bool {
        self == Self::Increments || place == InStep::Last
    }
}

/// Where in its step an increment is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InStep {
    /// More follow.
    Before,
    /// The last one.
    Last,
}

/// Whether errors of goals are asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GoalErrors {
    /// They are not.
    #[default]
    Left,
    /// Their estimates and bounds.
    Bounded,
}
