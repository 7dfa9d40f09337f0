//! Questions about the state of a run, answered.

use super::border::borderline;
use super::bound::bound;
use super::dual::{Dual, dual};
use super::error::GoalError;
use super::freed::Freed;
use super::gradient::{Answered, Free, gradients};
use super::history::refuse_history;
use crate::model::Model;
use crate::model::evaluate::Evaluation;
use crate::model::push::{Control, Part};
use crate::model::state::State;
use crate::report::{GoalBound, GoalReport};
use crate::scene::{Goal, GoalErrors, GoalKind, GoalQuestions, Parameter};
use crate::sqp::increment;
use crate::sqp::program::QuadraticProgram;
use crate::sqp::run::Run;

/// Largest residual of a state that counts as an equilibrium: looser than any tolerance that is
/// asked for.
const EQUILIBRIUM: f64 = 1e-3;

/// Answers `questions` at the state of `run`, each goal once with all that is asked of it.
///
/// # Errors
/// [`GoalError`].
pub(crate) fn answer(
    run: &mut Run<'_>,
    questions: &[GoalQuestions],
) -> Result<Vec<GoalReport>, GoalError> {
    let asked = Asked::of(questions);
    refuse_history((&run.model, &*run.state), !asked.parameters.is_empty())?;
    let now = run.evaluate();
    refuse_unbalanced(run, &now)?;
    let mut program = QuadraticProgram::new(run, &now, None, &mut 0.0);
    let duals = all(run, &mut program, asked.goals.iter())?;
    let pushes = asked.pushes(&run.model, run.state)?;
    let goals = pushes.iter().map(|(_, goal)| goal);
    let pushed = all(run, &mut program, goals)?;
    let controls: Vec<Control> = pushes.iter().map(|(control, _)| *control).collect();
    let answered = Answered {
        goals: &duals,
        pushed: &pushed,
        controls: &controls,
    };
    let free = Free::new((&run.model, &*run.state), &answered)?;
    let derived = gradients(run, (&answered, &free), &asked.parameters)?;
    let at = At {
        borderline: borderline(&run.model, run.state, &now),
        now,
    };
    let shares = free.shares(duals.len());
    let mut nodes = derived.nodes.into_iter();
    let all = duals.iter().zip(&shares).zip(derived.rows);
    let report = |((dual, shares), derivatives): ((&Dual, &Vec<f64>), Vec<f64>)| {
        let freed = Freed::new(dual, &pushed, shares);
        GoalReport {
            derivatives: asked.named(&dual.name, derivatives),
            by_nodes: nodes.next().filter(|_| asked.by_nodes(&dual.name)),
            ..at.report(
                (&run.model, &*run.state),
                (dual, &freed),
                asked.errors(&dual.name),
            )
        }
    };
    Ok(all.map(report).collect())
}

/// What questions ask for together.
struct Asked<'q> {
    questions: &'q [GoalQuestions],
    /// Each once, in the order of the questions.
    goals: Vec<Goal>,
    /// Each once.
    parameters: Vec<Parameter>,
}

impl<'q> Asked<'q> {
    fn of(questions: &'q [GoalQuestions]) -> Self {
        Self {
            questions,
            goals: once(questions.iter().flat_map(|one| &one.goals)),
            parameters: once(questions.iter().flat_map(|one| &one.parameters)),
        }
    }

    /// What obstacles are pushed by, where errors or derivatives are asked for.
    fn pushes(&self, model: &Model<'_>, state: &State) -> Result<Vec<(Control, Goal)>, GoalError> {
        let mut errors = self.questions.iter().map(|one| one.errors);
        if self.parameters.is_empty() && errors.all(|one| one == GoalErrors::Left) {
            Ok(Vec::new())
        } else {
            pushing_goals(model, state)
        }
    }

    /// The questions about a goal.
    fn about<'a>(&'a self, goal: &'a Goal) -> impl Iterator<Item = &'q GoalQuestions> + 'a {
        self.questions
            .iter()
            .filter(move |one| one.goals.contains(goal))
    }

    fn errors(&self, goal: &Goal) -> GoalErrors {
        let mut asked = self.about(goal).map(|one| one.errors);
        asked
            .find(|errors| *errors == GoalErrors::Bounded)
            .unwrap_or_default()
    }

    /// Whether the goal is differentiated by the places of the vertices.
    fn by_nodes(&self, goal: &Goal) -> bool {
        let mut asked = self.about(goal);
        asked.any(|one| one.parameters.contains(&Parameter::Mesh))
    }

    /// Those `derivatives` by all parameters that are asked of the goal.
    fn named(&self, goal: &Goal, derivatives: Vec<f64>) -> Vec<(String, f64)> {
        let all = self.parameters.iter().zip(derivatives);
        let of_goal = all.filter(|(parameter, _)| {
            self.about(goal)
                .any(|one| one.parameters.contains(parameter))
        });
        of_goal
            .map(|(one, value)| (one.to_string(), value))
            .collect()
    }
}

/// Each of `all` where it comes first.
fn once<'a, T: Clone + Eq + std::hash::Hash + 'a>(all: impl Iterator<Item = &'a T>) -> Vec<T> {
    let mut seen = std::collections::HashSet::new();
    all.filter(|one| seen.insert(*one)).cloned().collect()
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
}

impl At {
    /// What is known of a goal beside its name and its derivatives.
    fn report(
        &self,
        (model, state): (&Model<'_>, &State),
        (dual, freed): (&Dual, &Freed<'_>),
        errors: GoalErrors,
    ) -> GoalReport {
        let solver = freed.work(state, &self.now) * freed.unit();
        let bound = match errors {
            GoalErrors::Left => None,
            GoalErrors::Bounded => Some(GoalBound {
                solver: solver.abs(),
                ..bound(model, state, freed)
            }),
        };
        GoalReport {
            goal: dual.name.to_string(),
            value: dual.goal.value(model, state) * dual.goal.unit(),
            derivatives: Vec::new(),
            by_nodes: None,
            borderline: self.borderline,
            solver_error: solver,
            bound,
            dual_residual: dual.residual,
            applications: dual.applications,
            seconds: dual.seconds,
        }
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
            cause:
                "errors and derivatives where supports are pushed or sprung are not supported yet"
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
