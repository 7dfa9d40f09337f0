//! One increment under way: everything that solving it reads and changes.
//!
//! The fields are apart so that a function may borrow the model and change the state: what
//! it needs of both is passed as the run itself, or as the two or three fields in question. The
//! conditions of a solve never change under it: [`Run::under`] makes a run of its own.

use super::learned::Learned;
use super::watch::Watch;
use crate::linalg::Workspace;
use crate::model::Model;
use crate::model::conditions::Conditions;
use crate::model::counters::Counters;
use crate::model::evaluate::{Evaluation, evaluate};
use crate::model::state::State;
use crate::report::Termination;

constants! {
    /// Applications of an increment, over the mean of those that converged, after which nothing is
    /// tried anew that has failed: a corner that turns inside out took 250 times the mean.
    const MOST_OF_MEAN: u32 = 20;
    /// The least such bound, applications: the increment in which a straight cantilever bends aside
    /// takes more than 2,000, one of guides-cube-60 2,340.
    const LEAST_BOUND: u32 = 5_000;
    /// The same before an increment has converged: a cylinder pressed by a force with friction 100
    /// would spend 43,000 on parts of parts.
    const MOST_APPLICATIONS: u32 = 10_000;
}

/// One increment under way.
pub(crate) struct Run<'a> {
    /// The body on its obstacles, and the conditions of this solve.
    pub(crate) model: Model<'a>,
    /// Where the session is; moved by every accepted step.
    pub(crate) state: &'a mut State,
    /// What earlier programs have taught the solver, which may be dropped at any time.
    pub(crate) learned: &'a mut Learned,
    /// Who follows the increment, and what stops it.
    pub(crate) watch: Watch<'a>,
    /// Counts and wall seconds so far.
    pub(crate) counters: &'a mut Counters,
    /// Scratch vectors, handed back after use.
    pub(crate) work: &'a mut Workspace,
}

impl Run<'_> {
    /// Residuals at the present state, their seconds booked.
    pub(crate) fn evaluate(&mut self) -> Evaluation {
        let seconds = &mut self.counters.seconds;
        evaluate(&self.model, self.state, seconds, self.work)
    }

    /// Why the increment shall stop; none while it may go on.
    pub(crate) fn stopped(&self) -> Option<Termination> {
        self.watch.stopped(self.counters)
    }

    /// Whether the increment has cost so much that what has failed ends it.
    pub(crate) fn is_spent(&self) -> bool {
        let mean = self.learned.converged.mean();
        let most = mean.map_or(MOST_APPLICATIONS, |mean| {
            LEAST_BOUND.max(mean.saturating_mul(MOST_OF_MEAN))
        });
        self.counters.applications > most
    }

    /// The same increment under other conditions.
    pub(crate) fn under(&mut self, conditions: Conditions) -> Run<'_> {
        Run {
            model: Model {
                conditions,
                ..self.model.clone()
            },
            state: self.state,
            learned: self.learned,
            watch: self.watch.shared(),
            counters: self.counters,
            work: self.work,
        }
    }

    /// The same increment with no penetration admitted any more.
    pub(crate) fn with_nothing_admitted(&mut self) -> Run<'_> {
        let conditions = self.model.conditions.clone();
        self.under(Conditions {
            admitted_penetration: Default::default(),
            ..conditions
        })
    }

    /// The same increment to another tolerance.
    pub(crate) fn to(&mut self, tolerance: f64) -> Run<'_> {
        let conditions = self.model.conditions.clone();
        self.under(Conditions {
            tolerance,
            ..conditions
        })
    }
}
