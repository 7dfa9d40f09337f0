//! A flow to rest: a sequence of equilibria, each held back to the one before,
//!
//! ```text
//! f(u_k+1) = t_k M (u_k+1 - u_k)   with volume and contact
//! ```
//!
//! f the forces out of balance, M a mass ([`crate::model::proximal`]): the implicit Euler rule of a
//! body with a little viscosity, and down the energy where there is one (R. T. Rockafellar, SIAM J.
//! Control Optim. 14, 1976). With t large every step is a stable problem. What t is, when the end
//! without the proximal term is tried, and what ends the flow otherwise, is for its policy. Cost: a
//! solve a step.

use std::sync::Arc;

use super::increment;
use super::run::Run;
use crate::model::conditions::Conditions;
use crate::model::drive::Drive;
use crate::model::ending::Ending;
use crate::model::proximal::{Proximal, mass};
use crate::model::state::State;
use crate::report::{Cause, Termination};

/// What a step that was solved leads to.
pub(crate) enum Advance {
    /// Another step.
    Step,
    /// The end, without the proximal term.
    End,
    /// Nowhere: the flow ends for that reason.
    Nowhere(Cause),
}

/// What trying the end has led to.
pub(crate) enum End {
    /// The flow ends there.
    At(Box<Ending>),
    /// It is not there yet: another step, from where the end was tried.
    NotYet,
    /// Another step from where it has come to.
    Elsewhere,
}

/// What ends a flow, and what a failure changes.
pub(crate) struct Limits {
    /// Steps at most.
    pub(crate) steps: u32,
    /// Failures one after the other that end the flow.
    pub(crate) failures: u32,
    /// Change of the weight after a step that was not solved.
    pub(crate) heavier: f64,
}

/// How a flow goes.
pub(crate) trait Policy {
    /// What ends it.
    const LIMITS: Limits;

    /// Those of the next step, which are those of `run` but for the proximal term.
    fn conditions(&mut self, run: &mut Run<'_>) -> Conditions;

    /// Notes a step that was not solved; whether that ends the flow.
    fn fail(&mut self, run: &Run<'_>, ending: &mut Ending) -> bool;

    /// Takes over a step from `before` that was solved, and chooses the next weight.
    fn advance(&mut self, run: &mut Run<'_>, flow: &mut Flow, before: &State) -> Advance;

    /// Tries the end without the proximal term.
    fn end(&mut self, run: &mut Run<'_>, flow: &mut Flow, drive: &Drive) -> End;
}

/// Where a flow is.
pub(crate) struct Flow {
    /// M `[displacement]`.
    pub(crate) mass: Arc<[f64]>,
    /// t, non-dimensional.
    pub(crate) weight: f64,
}

impl Flow {
    /// From the present state, with the weight that `first` finds for its mass.
    pub(crate) fn new(run: &Run<'_>, first: impl FnOnce(&[f64]) -> f64) -> Self {
        let mass: Arc<[f64]> = mass(&run.model).into();
        Self {
            weight: first(&mass),
            mass,
        }
    }

    /// Steps until the policy ends the flow; how it ended, with a state of no use where it did not
    /// converge.
    pub(crate) fn follow<P: Policy>(
        mut self,
        run: &mut Run<'_>,
        drive: &Drive,
        policy: &mut P,
    ) -> Ending {
        let limits = P::LIMITS;
        let (mut steps, mut failures) = (0, 0);
        loop {
            let before = run.state.clone();
            let mut ending = self.step(run, drive, policy);
            steps += 1;
            if ending.is_stopped() {
                return ending;
            }
            if ending.termination != Termination::Converged {
                failures += 1;
                let is_over = policy.fail(run, &mut ending);
                if is_over || failures == limits.failures || steps == limits.steps {
                    return ending;
                }
                *run.state = before;
                self.weight *= limits.heavier;
                continue;
            }
            failures = 0;
            let ended = match policy.advance(run, &mut self, &before) {
                Advance::Step => None,
                Advance::End => self.end(run, drive, policy),
                Advance::Nowhere(cause) => Some(Ending {
                    termination: Termination::NotConverged,
                    cause: Some(cause),
                    ..ending
                }),
            };
            if let Some(ending) = ended {
                return ending;
            }
            if steps == limits.steps {
                return increment::out_of_iterations(run);
            }
        }
    }

    /// One step.
    fn step<P: Policy>(&self, run: &mut Run<'_>, drive: &Drive, policy: &mut P) -> Ending {
        let proximal = Proximal {
            weight: self.weight,
            anchor: run.state.displacement.clone().into(),
            mass: self.mass.clone(),
        };
        let conditions = run.model.conditions.clone();
        let mut held = run.under(Conditions {
            proximal: Some(proximal),
            ..conditions
        });
        let conditions = policy.conditions(&mut held);
        increment::solve(&mut held.under(conditions), drive)
    }

    /// Tries the end; how the flow ended there.
    fn end<P: Policy>(
        &mut self,
        run: &mut Run<'_>,
        drive: &Drive,
        policy: &mut P,
    ) -> Option<Ending> {
        let before = run.state.clone();
        match policy.end(run, self, drive) {
            End::At(ending) => return Some(*ending),
            End::NotYet => {
                // What a fluid has come to on the way stays wet: it moves the body on.
                let reached = std::mem::replace(&mut *run.state, before);
                run.state.wet = reached.wet;
                run.state.film = reached.film;
            }
            End::Elsewhere => {}
        }
        None
    }
}
