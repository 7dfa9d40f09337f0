//! Questions about the state of a run, answered.

use super::bound::bound;
use super::dual::{Dual, dual, work};
use super::error::GoalError;
use super::gradient::{Answered, gradients};
use crate::linalg::vector::norm;
use crate::model::Model;
use crate::model::evaluate::Evaluation;
use crate::model::push::{Control, Part};
use crate::model::state::State;
use crate::report::{GoalBound, GoalReport};
use crate::saddle::{AdmissibleSet, Status};
use crate::scene::{Goal, GoalErrors, GoalKind, GoalQuestions, Parameter};
use crate::sqp::increment;
use crate::sqp::program::QuadraticProgram;
use crate::sqp::run::Run;

/// Largest residual of a state that counts as an equilibrium: looser than any tolerance that is
/// asked for.
const EQUILIBRIUM: f64 = 1e-3;
/// Pressure over the largest one, and gap over the deepest motion, of a contact at its border.
const BORDER: f64 = 1e-6;

/// Answers `questions` at the state of `run`.
///
/// # Errors
/// [`GoalError`].
pub(crate) fn answer(
    run: &mut Run<'_>,
    questions: &GoalQuestions,
) -> Result<Vec<GoalReport>, GoalError> {
    refuse_history(&run.model)?;
    let now = run.evaluate();
    refuse_unbalanced(run, &now)?;
    let mut program = QuadraticProgram::new(run, &now, None, &mut 0.0);
    let duals = all(run, &mut program, questions.goals.iter())?;
    let derivatives = if questions.parameters.is_empty() {
        vec![Vec::new(); duals.len()]
    } else {
        let pushes = pushing_goals(&run.model, run.state)?;
        let goals = pushes.iter().map(|(_, goal)| goal);
        let pushed = all(run, &mut program, goals)?;
        let controls: Vec<Control> = pushes.iter().map(|(control, _)| *control).collect();
        let answered = Answered {
            goals: &duals,
            pushed: &pushed,
            controls: &controls,
        };
        gradients(run, &answered, &questions.parameters)?
    };
    let at = At {
        borderline: borderline(run.state, &now),
        errors: questions.errors,
        now,
    };
    let named = |derivatives: Vec<f64>| {
        let names = questions.parameters.iter().map(Parameter::to_string);
        names.zip(derivatives).collect()
    };
    let report = |(dual, derivatives): (&Dual, Vec<f64>)| GoalReport {
        derivatives: named(derivatives),
        ..at.report((&run.model, &*run.state), dual)
    };
    Ok(duals.iter().zip(derivatives).map(report).collect())
}

/// Dual solutions of `goals`.
fn all<'g>(
    run: &mut Run<'_>,
    program: &mut QuadraticProgram<'_>,
    goals: impl Iterator<Item = &'g Goal>,
) -> Result<Vec<Dual>, GoalError> {
    goals.map(|goal| dual(run, program, goal)).collect()
}

/// What all reports of a state share.
struct At {
    now: Evaluation,
    borderline: u32,
    errors: GoalErrors,
}

impl At {
    /// What is known of a goal beside its name and its derivatives.
    fn report(&self, (model, state): (&Model<'_>, &State), dual: &Dual) -> GoalReport {
        let solver = work(&dual.fields, &self.now) * dual.goal.unit();
        let bound = match self.errors {
            GoalErrors::Left => None,
            GoalErrors::Bounded => Some(GoalBound {
                solver: solver.abs(),
                ..bound(model, state, dual)
            }),
        };
        GoalReport {
            goal: dual.name.to_string(),
            value: dual.goal.value(model, state) * dual.goal.unit(),
            derivatives: Vec::new(),
            borderline: self.borderline,
            solver_error: solver,
            bound,
            dual_residual: dual.residual,
            applications: dual.applications,
            seconds: dual.seconds,
        }
    }
}

/// Refuses bodies whose state depends on its way.
fn refuse_history(model: &Model<'_>) -> Result<(), GoalError> {
    let problem = &model.plan.problem;
    if model.plan.has_friction() {
        Err(GoalError::NeedsHistory("friction"))
    } else if !problem.resolved.fluids.is_empty() {
        Err(GoalError::NeedsHistory("fluids"))
    } else {
        Ok(())
    }
}

/// Refuses states that are far from equilibrium.
fn refuse_unbalanced(run: &mut Run<'_>, now: &Evaluation) -> Result<(), GoalError> {
    let known = run.state.force_scale;
    let left = increment::residuals(run.state, now, known).largest();
    if left <= EQUILIBRIUM {
        Ok(())
    } else {
        Err(GoalError::NotInEquilibrium(left))
    }
}

/// What obstacles are pushed by, as goals: their poses follow from these.
fn pushing_goals(model: &Model<'_>, state: &State) -> Result<Vec<(Control, Goal)>, GoalError> {
    let controls = state.drive.controls().into_iter();
    let goal = |control: Control| match control.part {
        Part::Support(_) => Err(GoalError::Absent {
            text: control.key().to_owned(),
            cause: "derivatives where supports are pushed or sprung are not supported yet"
                .to_owned(),
        }),
        Part::Obstacle(index) => Ok((
            control,
            Goal {
                kind: if control.axis < 3 {
                    GoalKind::Force
                } else {
                    GoalKind::Moment
                },
                name: model.plan.problem.obstacles[index].name.clone(),
                axis: (control.axis % 3) as u8,
            },
        )),
    };
    controls.map(goal).collect()
}

/// Contacts of obstacles that are closed without pressure, or open without a gap.
fn borderline(state: &State, now: &Evaluation) -> u32 {
    let largest = state
        .multiplier
        .iter()
        .fold(0.0, |most: f64, l| most.max(l.abs()));
    let widest = norm(&now.gap);
    let all = now.sets.iter().flat_map(|part| {
        let is_contact = part.set == AdmissibleSet::NonNegative;
        std::iter::repeat_n(is_contact, part.size)
    });
    let contacts = all
        .zip(&state.status)
        .zip(state.multiplier.iter().zip(&now.gap));
    let at_border = contacts.filter(|((is_contact, status), (pressure, gap))| {
        *is_contact
            && match status {
                Status::Open => gap.abs() <= BORDER * widest,
                Status::Stick | Status::Slip => pressure.abs() <= BORDER * largest,
            }
    });
    at_border.count() as u32
}
