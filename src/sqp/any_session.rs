//! The session that callers see, on whichever element the plan asks for.

use std::sync::Arc;

use super::comparison;
use super::drive::ObstaclePose;
use super::session::{self, Reuse, StepRun};
use crate::mesh::Mesh;
use crate::plan::{Plan, Prepared, PreparedBody};
use crate::report::{CancelToken, FieldData, FieldName, Observer, StepReport};
use crate::scene::{SceneError, Step};

/// A state that load steps move.
#[derive(Debug)]
pub struct Session {
    kind: Kind,
    /// Keeps the shared data in use.
    _prepared: Arc<Prepared>,
}

#[derive(Debug)]
enum Kind {
    TaylorHood(Box<session::Session>),
    Comparison(Box<comparison::Session>),
}

/// Calls the same method on either kind.
macro_rules! on {
    ($session:expr, $inner:ident => $call:expr) => {
        match $session {
            Kind::TaylorHood($inner) => $call,
            Kind::Comparison($inner) => $call,
        }
    };
}

impl Session {
    /// A session in the undeformed state.
    pub fn new(plan: Arc<Plan>, mesh: Arc<Mesh>, prepared: Arc<Prepared>, reuse: Reuse) -> Self {
        let kind = match prepared.body() {
            PreparedBody::TaylorHood(data) => {
                let session = session::Session::new(plan, mesh, data, reuse);
                Kind::TaylorHood(Box::new(session))
            }
            PreparedBody::Comparison(data) => {
                let session = comparison::Session::new(plan, mesh, data, reuse);
                Kind::Comparison(Box::new(session))
            }
        };
        Self {
            kind,
            _prepared: prepared,
        }
    }

    /// The plan this session follows.
    pub fn plan(&self) -> &Plan {
        on!(&self.kind, session => session.plan())
    }

    /// Checks a step without taking it.
    ///
    /// # Errors
    /// [`SceneError`] with the path of every faulty key.
    pub fn check_step(&self, step: &Step) -> Result<(), SceneError> {
        on!(&self.kind, session => session.check_step(step))
    }

    /// Starts a step; [`Session::advance`] then does its increments.
    ///
    /// # Errors
    /// [`SceneError`]; the session is then as before.
    pub fn begin_step(&mut self, step: &Step) -> Result<StepRun, SceneError> {
        on!(&mut self.kind, session => session.begin_step(step))
    }

    /// Does the next increment; none when the step is finished. A result that
    /// did not converge finishes the step, with the last good state kept; one that
    /// was stopped leaves the state before the increment, so that no later bit
    /// depends on when that was. After a panic inside, [`Session::take_back`].
    pub fn advance(
        &mut self,
        run: &mut StepRun,
        observer: &mut dyn Observer,
        cancel: &CancelToken,
    ) -> Option<StepReport> {
        on!(&mut self.kind, session => session.advance(run, observer, cancel))
    }

    /// Ends a step before its end: what follows starts from the state that is
    /// there, as if the step had only asked for that. Forgets what the solver has
    /// learnt, which depends on how far it came: no later bit depends on when a
    /// step was stopped.
    pub fn stop(&mut self) {
        on!(&mut self.kind, session => session.stop());
    }

    /// Undoes the last increment, if it is not undone yet, and stops its step.
    /// Also mends a session in which [`Session::advance`] panicked.
    pub fn take_back(&mut self) {
        on!(&mut self.kind, session => session.take_back());
    }

    /// A field of the current state; none if the scene has no such field.
    pub fn field(&self, name: FieldName) -> Option<FieldData> {
        on!(&self.kind, session => session.field(name))
    }

    /// Bytes held by this session alone.
    pub fn bytes(&self) -> u64 {
        on!(&self.kind, session => session.bytes())
    }

    /// Current poses of all obstacles.
    pub fn obstacle_poses(&self) -> Vec<ObstaclePose> {
        on!(&self.kind, session => session.obstacle_poses())
    }
}
