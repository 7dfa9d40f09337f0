//! What a session asks of a discretised body, whatever its element: to be moved
//! through one increment, and to say where it then is.
//!
//! One trait with two implementations, Taylor-Hood and the elements that it is compared
//! with: steps, increments, limits and reports are the session's, once for all of them.

use std::fmt::Debug;
use std::sync::Arc;

use crate::linalg::Workspace;
use crate::mesh::Mesh;
use crate::model::counters::Counters;
use crate::model::drive::Drive;
use crate::model::ending::Ending;
use crate::model::friction::SlipStart;
use crate::model::state::{Start, State};
use crate::plan::Plan;
use crate::report::{FieldData, FieldName, Seconds, StepReport};
use crate::sqp::learned::Learned;
use crate::sqp::watch::Watch;

/// A body on its obstacles, with what all states of a session share.
pub(crate) trait Body: Debug + Send + Sync {
    /// The plan that the body follows.
    fn plan(&self) -> &Plan;

    /// The mesh of the plan.
    fn mesh(&self) -> &Mesh;

    /// Bytes, seconds and names of the prepared data.
    fn shared(&self) -> Shared;

    /// Bytes that the body holds for this session alone.
    fn bytes(&self) -> u64;

    /// Moves the state towards equilibrium under `goal`. An increment that something
    /// from outside stopped before any part of it converged leaves the state `before`.
    fn advance<'a>(&'a self, increment: Increment<'a>, goal: &Drive, before: &State) -> Advanced;

    /// Makes the state that of the whole body, and hands the scratch vectors back.
    fn complete<'a>(&'a self, at: Increment<'a>) -> Workspace;

    /// What each obstacle exerts on the body at `state`: forces, then moments about the
    /// reference points `[obstacles][6]`, in the caller's units.
    fn exerted(&self, state: &State) -> Vec<[f64; 6]>;

    /// The report of an increment, without what only the session knows.
    fn report(&self, state: &State, advanced: &mut Advanced) -> StepReport;

    /// Adds to a report what building the prepared data took beside seconds.
    fn count_preparation(&self, report: &mut StepReport);

    /// A field of `state` with what the solver has learnt on the way there; none if the scene has
    /// no such field.
    fn field(&self, at: (&State, &Learned), name: FieldName) -> Option<FieldData>;
}

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
