//! Why a goal or a derivative has no answer.

use crate::report::Termination;

/// Why a goal or a derivative has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GoalError {
    /// A name that the scene does not have.
    #[error("`{text}`: the scene has no {what} of that name")]
    Unknown {
        /// The goal or parameter.
        text: String,
        /// What it names.
        what: &'static str,
    },
    /// A component or constant that is not there.
    #[error("`{text}`: {cause}")]
    Absent {
        /// The goal or parameter.
        text: String,
        /// Why it is not there.
        cause: String,
    },
    /// The last increment did not converge, or there was none.
    #[error(
        "the state is no equilibrium (force out of balance {0:.1e} of its scale): goals are of \
         converged increments"
    )]
    NotInEquilibrium(f64),
    /// Friction in increments that did not begin at rest: the state depends on how it was reached.
    #[error(
        "the scene has friction over several increments: the state depends on its way, and \
         derivatives of the last increment alone would be wrong; values and bounds are told, \
         derivatives where the load comes in one increment"
    )]
    NeedsHistory,
    /// Where the last increment began is not known: its friction counts from there.
    #[error(
        "friction counts slip from where the increment began, which is not in a checkpoint: goals \
         are answered again after the next increment"
    )]
    UnknownStart,
    /// The dual problem was not solved.
    #[error("`{goal}`: the dual problem is solved to {residual:.1e} only; is the state stable?")]
    NotSolved {
        /// The goal.
        goal: String,
        /// Its residual over its scale.
        residual: f64,
    },
    /// The caller stopped it.
    #[error("stopped while goals were computed")]
    Stopped(Termination),
}
