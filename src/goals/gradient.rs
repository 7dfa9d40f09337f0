//! Derivatives of goals by parameters,
//!
//! ```text
//! dJ/dt = d/dt [J(x, t) + y . R(x, t)] at fixed x
//! ```
//!
//! by central differences of what the solver itself evaluates: exact to rounding for loads and for
//! constants that a law is linear in, of fourth order for other constants and for supports, to some 1e-11 of J, and of second order for
//! poses and shapes, whose steps are so short that rounding is larger than what the order leaves. Only the terms of R
//! that know the parameter are evaluated. Where poses follow from pushes F = T the derivatives at fixed poses q are freed of them,
//!
//! ```text
//! dJ/dt - (dJ/dq) (dF/dq)^-1 dF/dt,   dJ/dT = (dJ/dq) (dF/dq)^-1
//! ```
//!
//! Cost: two evaluations of terms of the residuals a parameter, four of constants and supports that they
//! are not linear in, for all goals together.

use super::change::Change;
use super::dual::Dual;
use super::error::GoalError;
use super::nodes::{self, ByNodes};
use crate::linalg::vector::norm;
use crate::linalg::{DenseLu, DenseMatrix, Workspace};
use crate::model::Model;
use crate::model::evaluate::evaluate_terms;
use crate::model::push::{Control, Part};
use crate::model::state::State;
use crate::scene::Parameter;
use crate::sqp::run::Run;

/// Weights of values one step away, over the step: exact for what is linear, else of second order.
const SECOND: [f64; 1] = [0.5];
/// The same of values one and two steps away: of fourth order.
const FOURTH: [f64; 2] = [2.0 / 3.0, -1.0 / 12.0];

/// Goals with their dual solutions.
pub(super) struct Answered<'a> {
    /// Those asked for.
    pub(super) goals: &'a [Dual],
    /// What obstacles and supports are pushed by.
    pub(super) pushed: &'a [Dual],
    /// The components of poses that follow from that.
    pub(super) controls: &'a [Control],
}

impl<'a> Answered<'a> {
    /// Those asked for, then those of pushes.
    fn all(&self) -> impl Iterator<Item = &'a Dual> {
        self.goals.iter().chain(self.pushed)
    }
}

/// What goals depend on, in the caller's units.
#[derive(Default)]
pub(super) struct Derived {
    /// By the parameters that have answers `[goals]`; by the places of all vertices the root of the sum
    /// of squares.
    pub(super) columns: Vec<(Parameter, Vec<f64>)>,
    /// By the places of the vertices `[goals][vertices]`; empty where that is not asked for.
    pub(super) nodes: Vec<ByNodes>,
    /// Why other parameters have none.
    pub(super) refused: Vec<GoalError>,
}

/// Derivatives of all goals by all parameters.
///
/// # Errors
/// [`GoalError::Stopped`].
pub(super) fn gradients(
    run: &Run<'_>,
    (answered, free): (&Answered<'_>, &Free),
    parameters: &[Parameter],
) -> Result<Derived, GoalError> {
    let mut derived = Derived::default();
    let at = (&run.model, &*run.state);
    for parameter in parameters {
        if let Some(stopped) = run.stopped() {
            return Err(GoalError::Stopped(stopped));
        }
        let column = if *parameter == Parameter::Mesh {
            free.by_nodes(at, answered).map(|nodes| {
                derived.nodes = nodes;
                let sizes = derived.nodes.iter();
                sizes.map(|own| norm(own.as_flattened())).collect()
            })
        } else {
            free.column(at, answered, parameter)
        };
        match column {
            Ok(column) => derived.columns.push((parameter.clone(), column)),
            Err(error) => derived.refused.push(error),
        }
    }
    Ok(derived)
}

/// How poses that follow from pushes answer.
#[derive(Default)]
pub(super) struct Free {
    /// (dF/dq)^-1; none where no pose follows.
    stiffness: Option<DenseLu>,
    /// dJ/dq `[controls][goals]`.
    by_pose: Vec<Vec<f64>>,
}

impl Free {
    /// From derivatives by the poses that follow.
    ///
    /// # Errors
    /// [`GoalError`] where what is pushed meets no resistance.
    pub(super) fn new(
        at: (&Model<'_>, &State),
        answered: &Answered<'_>,
    ) -> Result<Self, GoalError> {
        let mut by_pose = Vec::new();
        let count = answered.pushed.len();
        let mut stiffness = DenseMatrix::zeros(count, count);
        let controls = if count == 0 {
            &[][..]
        } else {
            answered.controls
        };
        for (column, control) in controls.iter().enumerate() {
            let change = Change::new(at, &of_pose(at.0, *control))?;
            let mut values = differentiate(at, answered, &change)?;
            let pushed = values.split_off(answered.goals.len());
            for (row, value) in pushed.into_iter().enumerate() {
                *stiffness.at_mut(row, column) = value;
            }
            *stiffness.at_mut(column, column) += spring(at.0, *control);
            by_pose.push(values);
        }
        let stiffness = (count > 0).then(|| DenseLu::new(&stiffness)).transpose();
        Ok(Self {
            stiffness: stiffness.map_err(|_| GoalError::Absent {
                text: "pose".to_owned(),
                cause: "what is pushed meets no resistance: its pose has no derivative".to_owned(),
            })?,
            by_pose,
        })
    }

    /// Derivatives of all goals by one parameter.
    fn column(
        &self,
        at: (&Model<'_>, &State),
        answered: &Answered<'_>,
        parameter: &Parameter,
    ) -> Result<Vec<f64>, GoalError> {
        let change = Change::new(at, parameter)?;
        let own = change.place.control();
        let control = answered.controls.iter().position(|one| Some(*one) == own);
        let absent = |cause: &str| {
            Err(GoalError::Absent {
                text: parameter.to_string(),
                cause: cause.to_owned(),
            })
        };
        match (parameter, control) {
            (Parameter::Push { .. }, None) => {
                absent("nothing pushes the obstacle so; its `translation` and `rotation` are given")
            }
            (Parameter::SupportPush { .. }, None) => {
                absent("nothing pushes the support so; its displacement is given")
            }
            (Parameter::Push { .. } | Parameter::SupportPush { .. }, Some(place)) => {
                let mut unit = vec![0.0; answered.controls.len()];
                unit[place] = 1.0;
                Ok(self.led(answered.goals.len(), unit))
            }
            (_, Some(_)) => {
                absent("the pose follows from a push: ask for the `force` or `moment` in its place")
            }
            (_, None) => {
                let mut values = differentiate(at, answered, &change)?;
                let pushed = values.split_off(answered.goals.len());
                let led = self.led(values.len(), pushed);
                values
                    .iter_mut()
                    .zip(led)
                    .for_each(|(own, led)| *own -= led);
                Ok(values)
            }
        }
    }

    /// (dJ/dq) (dF/dq)^-1 `[goals][controls]`, in the caller's units.
    pub(super) fn shares(&self, goals: usize) -> Vec<Vec<f64>> {
        let count = self.by_pose.len();
        let mut shares = vec![Vec::with_capacity(count); goals];
        for control in 0..count {
            let mut unit = vec![0.0; count];
            unit[control] = 1.0;
            let column = self.led(goals, unit);
            shares
                .iter_mut()
                .zip(column)
                .for_each(|(row, value)| row.push(value));
        }
        shares
    }

    /// Derivatives of all goals by the places of the vertices.
    fn by_nodes(
        &self,
        (model, state): (&Model<'_>, &State),
        answered: &Answered<'_>,
    ) -> Result<Vec<ByNodes>, GoalError> {
        nodes::refuse(model, state)?;
        let all = answered.all();
        let mut all: Vec<ByNodes> = all
            .map(|dual| nodes::by_nodes(model, state, dual))
            .collect();
        let count = answered.goals.len();
        let pushed = all.split_off(count);
        for (place, forces) in pushed.iter().enumerate() {
            let mut unit = vec![0.0; pushed.len()];
            unit[place] = 1.0;
            for (own, led) in all.iter_mut().zip(self.led(count, unit)) {
                let values = own.as_flattened_mut().iter_mut();
                let values = values.zip(forces.as_flattened());
                values.for_each(|(own, force)| *own -= led * force);
            }
        }
        Ok(all)
    }

    /// (dJ/dq) (dF/dq)^-1 `forces`, of that many goals.
    fn led(&self, goals: usize, mut forces: Vec<f64>) -> Vec<f64> {
        let mut led = vec![0.0; goals];
        if let Some(stiffness) = &self.stiffness {
            stiffness.solve(&mut forces);
            for (by_pose, motion) in self.by_pose.iter().zip(forces) {
                led.iter_mut()
                    .zip(by_pose)
                    .for_each(|(sum, value)| *sum += value * motion);
            }
        }
        led
    }
}

/// The component of a pose as a parameter.
fn of_pose(model: &Model<'_>, control: Control) -> Parameter {
    let (problem, axis) = (&model.plan.problem, control.axis as u8);
    match control.part {
        Part::Obstacle(index) => Parameter::Pose {
            obstacle: problem.obstacles[index].name.clone(),
            axis,
        },
        Part::Support(index) => Parameter::SupportPush {
            support: problem.resolved.supports[index].name.clone(),
            axis,
        },
    }
}

/// What a spring takes of the push of a support for each unit of its way, in the caller's units.
fn spring(model: &Model<'_>, control: Control) -> f64 {
    match control.part {
        Part::Obstacle(_) => 0.0,
        Part::Support(index) => model.plan.problem.resolved.supports[index].spring[control.axis],
    }
}

/// Derivatives of all goals with the poses held fast.
fn differentiate(
    at: (&Model<'_>, &State),
    answered: &Answered<'_>,
    change: &Change,
) -> Result<Vec<f64>, GoalError> {
    let mut sums = vec![0.0; answered.all().count()];
    let weights = if change.is_linear || change.place.is_geometric() {
        &SECOND[..]
    } else {
        &FOURTH
    };
    for (place, weight) in weights.iter().enumerate() {
        for sign in [1.0, -1.0] {
            let by = sign * (place + 1) as f64 * change.step;
            let values = lagrangians(at, answered, (change, by))?;
            let factor = sign * weight / change.step;
            sums.iter_mut()
                .zip(values)
                .for_each(|(sum, value)| *sum += factor * value);
        }
    }
    Ok(sums)
}

/// J + y . R of all goals, in the caller's units of J, with the parameter larger by some amount, but for
/// what does not depend on it.
fn lagrangians(
    at: (&Model<'_>, &State),
    answered: &Answered<'_>,
    (change, by): (&Change, f64),
) -> Result<Vec<f64>, GoalError> {
    let changed = change.apply(at, by)?;
    let (model, state) = (changed.model(), &changed.state);
    let terms = change.place.terms();
    let now = evaluate_terms((&model, state), terms, &mut Workspace::new());
    let value = |dual: &Dual| {
        let own = if dual.goal.reads(terms) {
            dual.goal.value(&model, state)
        } else {
            0.0
        };
        (own + dual.work(state, &now)) * dual.goal.unit()
    };
    Ok(answered.all().map(value).collect())
}
