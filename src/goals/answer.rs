//! Questions about the state of a run, answered.

use super::border::borderline;
use super::bound::bound;
use super::dual::{Dual, Purpose, dual};
use super::error::GoalError;
use super::freed::Freed;
use super::gradient::{Answered, Derived, Free, gradients};
use super::history::refuse_history;
use crate::model::Model;
use crate::model::evaluate::Evaluation;
use crate::model::push::{Control, Part};
use crate::model::state::State;
use crate::plan::pairs::PlannedPair;
use crate::report::{GoalBound, GoalReport};
use crate::scene::{Goal, GoalErrors, GoalKind, GoalQuestions, Parameter};
use crate::sqp::fields::Fields;
use crate::sqp::increment;
use crate::sqp::program::QuadraticProgram;
use crate::sqp::run::Run;

/// Largest residual of a state that counts as an equilibrium: looser than any tolerance that is
/// asked for.
const EQUILIBRIUM: f64 = 1e-3;

/// Answers to questions, and why others have none.
#[derive(Default)]
pub(crate) struct Answers {
    /// Each goal once.
    pub(crate) goals: Vec<GoalReport>,
    /// Of goals, of parameters of all of them, or of what a state knows.
    pub(crate) refused: Vec<GoalError>,
    /// Dual solutions of the goals.
    pub(crate) duals: Vec<(String, Fields)>,
}

/// Answers `questions` at the state of `run`, each goal once with all that is asked of it. What has no
/// answer keeps nothing else from having one.
///
/// # Errors
/// [`GoalError`] where the state as a whole has none, and where it was stopped.
pub(crate) fn answer(run: &mut Run<'_>, questions: &[GoalQuestions]) -> Result<Answers, GoalError> {
    let mut asked = Asked::of(questions);
    let mut answers = Answers::default();
    leave_out_derivatives((&run.model, &*run.state), &mut asked, &mut answers.refused)?;
    let now = run.evaluate();
    refuse_unbalanced(run, &now)?;
    let mut program = QuadraticProgram::new(run, &now, None, &mut 0.0);
    // Those of other programs.
    run.learned.directions.clear(run.work);
    let duals = all(run, &mut program, (&asked, &mut answers.refused))?;
    let freeing = Freeing::new(run, &mut program, (&asked, &duals));
    let freeing = freeing.or_else(|error| answers.leave_out(error))?;
    let at = At {
        borderline: borderline(&run.model, run.state, &now),
        now,
    };
    match freeing {
        Some(freeing) => {
            let derived = freeing.derived(run, (&asked, &duals))?;
            let of_goal = |place: usize, dual: &Dual| GoalReport {
                derivatives: asked.named((place, &dual.name), &derived),
                by_nodes: (derived.nodes.get(place).cloned())
                    .filter(|_| asked.by_nodes(&dual.name)),
                ..at.report(
                    (&run.model, &*run.state),
                    (dual, &freeing.freed(place, dual)),
                    asked.errors(&dual.name),
                )
            };
            let all = duals.iter().enumerate();
            answers.goals = all.map(|(place, dual)| of_goal(place, dual)).collect();
            answers.refused.extend(derived.refused);
        }
        None => {
            let model = (&run.model, &*run.state);
            let value =
                |dual| at.report(model, (dual, &Freed::new(dual, &[], &[])), GoalErrors::Left);
            answers.goals = duals.iter().map(value).collect();
        }
    }
    let solved = duals.into_iter();
    answers.duals = solved
        .map(|one| (one.name.to_string(), one.fields))
        .collect();
    Ok(answers)
}

impl Answers {
    /// Leaves something out that others do not need.
    ///
    /// # Errors
    /// [`GoalError::Stopped`].
    fn leave_out<T>(&mut self, error: GoalError) -> Result<Option<T>, GoalError> {
        if matches!(error, GoalError::Stopped(_)) {
            return Err(error);
        }
        self.refused.push(error);
        Ok(None)
    }
}

/// What frees goals of the poses that follow from pushes.
struct Freeing {
    /// What obstacles and supports are pushed by.
    pushed: Vec<Dual>,
    controls: Vec<Control>,
    free: Free,
    /// What each goal has of each push.
    shares: Vec<Vec<f64>>,
}

impl Freeing {
    /// None is needed where nothing is pushed.
    fn new(
        run: &mut Run<'_>,
        program: &mut QuadraticProgram<'_>,
        (asked, duals): (&Asked<'_>, &[Dual]),
    ) -> Result<Option<Self>, GoalError> {
        let pushes = asked.pushes(&run.model, run.state)?;
        let purpose = asked.purpose();
        let pushed = pushes
            .iter()
            .map(|(_, goal)| dual(run, program, (goal, purpose)));
        let pushed: Vec<Dual> = pushed.collect::<Result<_, _>>()?;
        let controls: Vec<Control> = pushes.iter().map(|(control, _)| *control).collect();
        let answered = Answered {
            goals: duals,
            pushed: &pushed,
            controls: &controls,
        };
        let free = Free::new((&run.model, &*run.state), &answered)?;
        Ok(Some(Self {
            shares: free.shares(duals.len()),
            pushed,
            controls,
            free,
        }))
    }

    fn derived(
        &self,
        run: &Run<'_>,
        (asked, duals): (&Asked<'_>, &[Dual]),
    ) -> Result<Derived, GoalError> {
        let answered = Answered {
            goals: duals,
            pushed: &self.pushed,
            controls: &self.controls,
        };
        gradients(run, (&answered, &self.free), &asked.parameters)
    }

    fn freed<'a>(&'a self, place: usize, dual: &'a Dual) -> Freed<'a> {
        let shares = self.shares.get(place).map_or(&[][..], |own| own);
        Freed::new(dual, &self.pushed, shares)
    }
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

    fn purpose(&self) -> Purpose {
        if self.parameters.is_empty() {
            Purpose::Bounds
        } else {
            Purpose::Derivatives
        }
    }

    /// What the goal is asked for; after history has refused derivatives, bounds at most.
    fn purpose_of(&self, goal: &Goal) -> Purpose {
        let is_bounded_only = self.about(goal).all(|one| one.parameters.is_empty());
        if is_bounded_only {
            Purpose::Bounds
        } else {
            self.purpose()
        }
    }

    /// What obstacles and supports are pushed by, where errors or derivatives are asked for.
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

    /// The derivatives of the goal of that place that are asked of it.
    fn named(&self, (place, goal): (usize, &Goal), derived: &Derived) -> Vec<(String, f64)> {
        let of_goal = derived.columns.iter().filter(|(parameter, _)| {
            self.about(goal)
                .any(|one| one.parameters.contains(parameter))
        });
        let values =
            of_goal.filter_map(|(one, column)| Some((one.to_string(), *column.get(place)?)));
        values.collect()
    }
}

/// Each of `all` where it comes first.
fn once<'a, T: Clone + Eq + std::hash::Hash + 'a>(all: impl Iterator<Item = &'a T>) -> Vec<T> {
    let mut seen = std::collections::HashSet::new();
    all.filter(|one| seen.insert(*one)).cloned().collect()
}

/// Dual solutions of the goals that have one.
///
/// # Errors
/// [`GoalError::Stopped`].
fn all(
    run: &mut Run<'_>,
    program: &mut QuadraticProgram<'_>,
    (asked, refused): (&Asked<'_>, &mut Vec<GoalError>),
) -> Result<Vec<Dual>, GoalError> {
    let mut duals = Vec::with_capacity(asked.goals.len());
    for goal in &asked.goals {
        match dual(run, program, (goal, asked.purpose_of(goal))) {
            Ok(dual) => duals.push(dual),
            Err(error @ GoalError::Stopped(_)) => return Err(error),
            Err(error) => refused.push(error),
        }
    }
    Ok(duals)
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

/// Leaves derivatives out that the state does not have: values and bounds are those of the last
/// increment's own problem.
fn leave_out_derivatives(
    (model, state): (&Model<'_>, &State),
    asked: &mut Asked<'_>,
    refused: &mut Vec<GoalError>,
) -> Result<(), GoalError> {
    let asks_for_derivatives = !asked.parameters.is_empty();
    let history = match refuse_history((model, state), asks_for_derivatives) {
        Err(error @ GoalError::NeedsHistory) => Some(error),
        other => other.map(|()| None)?,
    };
    let inexact = inexact_derivatives(model).filter(|_| asks_for_derivatives);
    if let Some(error) = inexact.or(history) {
        asked.parameters.clear();
        refused.push(error);
    }
    Ok(())
}

/// Why the matrix of a scene gives no exact derivatives.
fn inexact_derivatives(model: &Model<'_>) -> Option<GoalError> {
    let place = if rubs_in_space(model) {
        "where bodies rub on each other in space"
    } else if has_films(model) {
        "beside fluids that come between bodies"
    } else {
        return None;
    };
    Some(GoalError::Absent {
        text: "to".to_owned(),
        cause: format!("derivatives {place} are not exact yet; values and bounds are told"),
    })
}

/// Whether a fluid may come between bodies: what is wet of the surface that does not carry goes along
/// with what it slides over, which the matrix leaves out.
fn has_films(model: &Model<'_>) -> bool {
    let problem = &model.plan.problem;
    let is_reached = |facet: u32| {
        let vertices = model.mesh.facet(facet as usize);
        let mut fluids = problem.fluid_surfaces.iter();
        fluids.any(|one| {
            let mut vertices = vertices.iter();
            vertices.all(|vertex| one.nodes.binary_search(vertex).is_ok())
        })
    };
    let facets = |pair: &PlannedPair| [&pair.carrier[..], &pair.other].concat();
    let mut facets = problem.pairs.iter().flat_map(facets);
    facets.any(is_reached)
}

/// Whether bodies in space rub on each other, whose matrix leaves out how borders of pieces move with
/// tractions.
fn rubs_in_space(model: &Model<'_>) -> bool {
    let problem = &model.plan.problem;
    problem.units.dimension == 3 && problem.pairs.iter().any(|pair| pair.is_frictional())
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

/// What obstacles and supports are pushed by, as goals: their poses follow from these.
fn pushing_goals(model: &Model<'_>, state: &State) -> Result<Vec<(Control, Goal)>, GoalError> {
    let controls = state.drive.controls().into_iter();
    let goal = |control: Control| match control.part {
        Part::Support(_) if control.axis >= 3 => Err(GoalError::Absent {
            text: control.key().to_owned(),
            cause:
                "errors and derivatives where supports are turned by moments or springs are not \
                 known yet; prescribe the rotation that the support has reached"
                    .to_owned(),
        }),
        Part::Support(index) => Ok((
            control,
            Goal {
                kind: GoalKind::Reaction,
                name: model.plan.problem.resolved.supports[index].name.clone(),
                axis: control.axis as u8,
            },
        )),
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
