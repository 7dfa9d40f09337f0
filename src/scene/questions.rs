//! What is asked of increments beside their results.

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
}

impl Scene {
    /// The first questions about errors; none where no error is asked for.
    pub(crate) fn bounded(&self) -> Option<&GoalQuestions> {
        let mut all = self.questions.iter();
        all.find(|one| one.errors == GoalErrors::Bounded)
    }
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
