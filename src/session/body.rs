//! What a session hands to its body for one increment, and what it gets back.

use std::sync::Arc;

use crate::linalg::Workspace;
use crate::model::counters::Counters;
use crate::model::ending::Ending;
use crate::model::friction::SlipStart;
use crate::model::state::{Start, State};
use crate::report::Seconds;
use crate::sqp::learned::Learned;
use crate::sqp::watch::Watch;

/// The prepared data of a body.
pub(crate) struct Shared {
    /// Bytes of memory that the prepared data hold.
    pub(crate) bytes: u64,
    /// Wall seconds that building them took, by phase.
    pub(crate) seconds: Seconds,
    /// Names of the parts that were built, for reports of what is reused.
    pub(crate) parts: Vec<String>,
}

/// What an increment reads and changes beside the body.
pub(crate) struct Increment<'a> {
    /// Where the session is: the checkpoint, moved by the increment.
    pub(crate) state: &'a mut State,
    /// What earlier programs have taught the solver, which may be dropped at any time.
    pub(crate) learned: &'a mut Learned,
    /// Who follows the increment, and what stops it.
    pub(crate) watch: Watch<'a>,
    /// Counts and wall seconds so far.
    pub(crate) counters: Counters,
    /// Scratch vectors, which the next increment takes over.
    pub(crate) work: Workspace,
}

/// An increment that is over.
pub(crate) struct Advanced {
    /// How the increment ended.
    pub(crate) ending: Ending,
    /// Part of the increment that the state has come to, from zero to one.
    pub(crate) part: f64,
    /// Where the body was before it.
    pub(crate) start: Start,
    /// Where slip counts from; none without friction.
    pub(crate) slip_start: Option<Arc<SlipStart>>,
    /// Counts and wall seconds of the increment.
    pub(crate) counters: Counters,
    /// Scratch vectors, for the next increment.
    pub(crate) work: Workspace,
}
