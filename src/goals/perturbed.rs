//! The body with one parameter changed and the state held fast: what residuals and goals are
//! differentiated with.
//!
//! Units stay those of the plan, so that the numbers of the state mean the same. What a parameter
//! does not touch is borrowed. Cost: of a material the operators without their inverses, of a shape
//! the surfaces, of others nothing.

use super::error::GoalError;
use super::place::{Place, place};
use crate::mesh::Mesh;
use crate::model::Model;
use crate::model::interfaces::Interfaces;
use crate::model::loads::reference_load;
use crate::model::prescribed::prescribe;
use crate::model::state::State;
use crate::plan::Plan;
use crate::prepare::TaylorHoodData;
use crate::scene::Parameter;
use crate::scene::numbers::{constant, number};
use crate::scene::validate::laws;

/// How many times longer steps are of what residuals are linear in: with less rounding. Without unit;
/// chosen.
const OF_LINEAR: f64 = 10.0;

/// A parameter with what it is changed by.
#[derive(Clone, Debug)]
pub(super) struct Change {
    pub(super) place: Place,
    /// The parameter as it was named.
    text: String,
    /// In the caller's units.
    pub(super) step: f64,
    /// Whether J and R are linear in it at a given state.
    pub(super) is_linear: bool,
}

/// A body with a changed parameter.
pub(super) struct Perturbed<'a> {
    base: &'a Model<'a>,
    plan: Option<Plan>,
    prepared: Option<TaylorHoodData>,
    interfaces: Option<Interfaces>,
    load: Option<Vec<f64>>,
    pub(super) state: State,
}

impl Change {
    /// Of a parameter of the scene; `state` says where its steps have led.
    ///
    /// # Errors
    /// [`GoalError::Unknown`] and [`GoalError::Absent`].
    pub(super) fn new(
        (model, state): (&Model<'_>, &State),
        parameter: &Parameter,
    ) -> Result<Self, GoalError> {
        let place = place(model, parameter)?;
        let text = parameter.to_string();
        let step = place
            .step((model, state))
            .map_err(|cause| GoalError::Absent {
                text: text.clone(),
                cause: cause.to_owned(),
            })?;
        let is_linear = place.is_linear(model);
        Ok(Self {
            step: if is_linear { OF_LINEAR * step } else { step },
            place,
            text,
            is_linear,
        })
    }

    /// The body with the parameter larger by `by`.
    ///
    /// # Errors
    /// [`GoalError::Absent`] where the law or the shape has no meaning there.
    pub(super) fn apply<'a>(
        &self,
        (model, state): (&'a Model<'a>, &State),
        by: f64,
    ) -> Result<Perturbed<'a>, GoalError> {
        let mut changed = Perturbed {
            base: model,
            plan: None,
            prepared: None,
            interfaces: None,
            load: None,
            state: state.clone(),
        };
        let outside = |cause: String| GoalError::Absent {
            text: self.text.clone(),
            cause,
        };
        match &self.place {
            Place::Material(index, key) => {
                changed.set_constant((*index, key), by).map_err(outside)?
            }
            Place::Shape(index, key) => changed.set_shape((*index, key), by).map_err(outside)?,
            Place::Pose(index, axis) => changed.set_pose(*index, *axis, by),
            Place::Load => changed.state.drive.load += by,
            Place::Friction(index) => changed.state.drive.friction[*index] += by,
            Place::Fluid(index) => changed.state.drive.fluids[*index].pressure += by,
            Place::Tresca(_)
            | Place::PairFriction(_)
            | Place::PairTresca(_)
            | Place::Pressure(_)
            | Place::Traction(..)
            | Place::BodyForce(_) => changed.set_planned(&self.place, by),
            Place::Support(index, axis) => {
                changed.state.drive.supports[*index][*axis] += by;
                let drive = changed.state.drive.clone();
                prescribe(model, &drive, &mut changed.state.displacement);
            }
        }
        Ok(changed)
    }
}

impl<'a> Perturbed<'a> {
    /// The changed body.
    pub(super) fn model(&self) -> Model<'_> {
        Model {
            plan: self.plan.as_ref().unwrap_or(self.base.plan),
            mesh: self.base.mesh,
            prepared: self.prepared.as_ref().unwrap_or(self.base.prepared),
            interfaces: self.interfaces.as_ref().unwrap_or(self.base.interfaces),
            load: self.load.as_deref().unwrap_or(self.base.load),
            conditions: self.base.conditions.clone(),
        }
    }

    fn mesh(&self) -> &'a Mesh {
        self.base.mesh
    }

    fn set_constant(&mut self, (index, key): (usize, &str), by: f64) -> Result<(), String> {
        let mut plan = self.base.plan.clone();
        let scene = &mut plan.problem.scene;
        if let Some(value) = constant(&mut scene.materials[index].model, key) {
            *value += by;
        }
        let found = laws(scene, self.mesh()).map_err(|error| error.to_string())?;
        plan.problem.resolved.materials = found;
        self.prepared = Some(self.base.prepared.with_laws(&plan, self.mesh()));
        self.plan = Some(plan);
        Ok(())
    }

    fn set_shape(&mut self, (index, key): (usize, &str), by: f64) -> Result<(), String> {
        let mut plan = self.base.plan.clone();
        let problem = &mut plan.problem;
        let shape = &mut problem.scene.obstacles[index].shape;
        if let Some(value) = number(shape, key) {
            *value += by;
        }
        let built = shape.build(problem.units.length);
        let built = built.map_err(|error| error.to_string())?;
        self.interfaces = Some(self.base.interfaces.with_shape(index, built.clone()));
        problem.obstacles[index].shape = built;
        self.plan = Some(plan);
        Ok(())
    }

    fn set_pose(&mut self, index: usize, axis: usize, by: f64) {
        let pose = &mut self.state.drive.poses[index];
        match axis.checked_sub(3) {
            None => pose.translation[axis] += by,
            Some(about) => pose.rotation[about] += by,
        }
    }

    /// Changes what the plan alone knows.
    fn set_planned(&mut self, place: &Place, by: f64) {
        let mut plan = self.base.plan.clone();
        let problem = &mut plan.problem;
        let bound = |bound: &mut Option<f64>| {
            if let Some(bound) = bound {
                *bound += by;
            }
        };
        match place {
            Place::Tresca(index) => bound(&mut problem.obstacles[*index].tresca),
            Place::PairTresca(index) => bound(&mut problem.pairs[*index].tresca),
            Place::PairFriction(index) => problem.pairs[*index].friction += by,
            Place::Pressure(index) => problem.resolved.pressures[*index].value += by,
            Place::Traction(index, axis) => {
                problem.resolved.tractions[*index].value[*axis] += by;
                self.load = Some(reference_load(&plan, self.mesh(), self.base.prepared));
            }
            Place::BodyForce(axis) => {
                problem.resolved.body_force[*axis] += by;
                self.load = Some(reference_load(&plan, self.mesh(), self.base.prepared));
            }
            Place::Material(..)
            | Place::Shape(..)
            | Place::Pose(..)
            | Place::Load
            | Place::Friction(_)
            | Place::Fluid(_)
            | Place::Support(..) => {}
        }
        self.plan = Some(plan);
    }
}
