//! The body with one parameter changed and the state held fast: what residuals and goals are
//! differentiated with.
//!
//! Units stay those of the plan, so that the numbers of the state mean the same. What a parameter
//! does not touch is borrowed. Cost: of a material the operators without their inverses, of a shape
//! the surfaces, of others nothing.

use super::error::GoalError;
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

/// Step of a material's constant, over its size.
const OF_CONSTANTS: f64 = 1e-4;
/// Step of a length over that of the body, and of an angle: as short as rounding lets it be, since points of
/// contact that cross a jump of curvature on the way, where an edge is rounded, see both sides of it. Without unit; at 1e-4 a rounded box had
/// derivatives 3 % off (measured against differences of whole solves), at 1e-6 they agree to five digits.
const OF_LENGTHS: f64 = 1e-6;

/// A parameter found in the scene.
#[derive(Clone, Debug)]
pub(super) enum Place {
    /// Number of the material, key.
    Material(usize, String),
    /// Number of the obstacle, axis of its pose.
    Pose(usize, usize),
    /// Number of the obstacle, key.
    Shape(usize, String),
    /// Number of the obstacle.
    Friction(usize),
    /// The same, with a given bound.
    Tresca(usize),
    /// Of all loads.
    Load,
    /// Number of the pressure.
    Pressure(usize),
    /// Number of the traction, axis.
    Traction(usize, usize),
    /// Axis.
    BodyForce(usize),
    /// Number of the support, axis.
    Support(usize, usize),
}

/// A parameter with what it is changed by.
#[derive(Clone, Debug)]
pub(super) struct Change {
    pub(super) place: Place,
    /// The parameter as it was named.
    text: String,
    /// In the caller's units.
    pub(super) step: f64,
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
        let mut scene = model.plan.problem.scene.clone();
        let units = &model.plan.problem.units;
        let text = parameter.to_string();
        let absent = |cause: &str| GoalError::Absent {
            text: text.clone(),
            cause: cause.to_owned(),
        };
        let length = OF_LENGTHS * units.length;
        let step = match &place {
            Place::Material(index, key) => {
                let found = constant(&mut scene.materials[*index].model, key);
                let value = *found.ok_or_else(|| absent("the law has no such finite constant"))?;
                let size = match (value == 0.0, is_stress(key)) {
                    (true, true) => units.stress,
                    (true, false) => 1.0,
                    (false, _) => value.abs(),
                };
                let room = if key == "poisson_ratio" {
                    0.25 * (0.5 - value)
                } else {
                    f64::INFINITY
                };
                if room <= 0.0 {
                    return Err(absent(
                        "one half is the end of its range: it has no derivative from both sides",
                    ));
                }
                room.min(OF_CONSTANTS * size)
            }
            Place::Shape(index, key) => {
                let found = number(&mut scene.obstacles[*index].shape, key);
                let value = *found.ok_or_else(|| absent("the shape has no such number"))?;
                match key.as_str() {
                    "angle" => OF_LENGTHS,
                    key if key.starts_with("normal") || key.starts_with("axis") => OF_LENGTHS,
                    _ if value > 0.0 => length.min(OF_LENGTHS * value),
                    _ => length,
                }
            }
            Place::Pose(_, axis) if *axis >= 3 => OF_LENGTHS,
            Place::Pose(..) | Place::Support(..) => length,
            Place::Load => OF_CONSTANTS * state.drive.load.abs().max(1.0),
            Place::Friction(index) => friction_step((model, state), *index).map_err(absent)?,
            Place::Tresca(index) if model.plan.problem.obstacles[*index].tresca.is_none() => {
                return Err(absent("the obstacle has no bound on its tractions"));
            }
            Place::Pressure(_) | Place::Traction(..) | Place::Tresca(_) => {
                OF_CONSTANTS * units.stress
            }
            Place::BodyForce(_) => OF_CONSTANTS * units.body_force(),
        };
        Ok(Self { place, text, step })
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
            Place::Tresca(index) => {
                let mut plan = model.plan.clone();
                if let Some(bound) = &mut plan.problem.obstacles[*index].tresca {
                    *bound += by;
                }
                changed.plan = Some(plan);
            }
            Place::Pressure(index) => {
                let mut plan = model.plan.clone();
                plan.problem.resolved.pressures[*index].value += by;
                changed.plan = Some(plan);
            }
            Place::Traction(index, axis) => {
                let mut plan = model.plan.clone();
                plan.problem.resolved.tractions[*index].value[*axis] += by;
                changed.set_load(plan);
            }
            Place::BodyForce(axis) => {
                let mut plan = model.plan.clone();
                plan.problem.resolved.body_force[*axis] += by;
                changed.set_load(plan);
            }
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
        problem.obstacles[index].shape = built.map_err(|error| error.to_string())?;
        let space = &self.base.prepared.space;
        self.interfaces = Some(Interfaces::new(&plan, self.mesh(), space));
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

    fn set_load(&mut self, plan: Plan) {
        self.load = Some(reference_load(&plan, self.mesh(), self.base.prepared));
        self.plan = Some(plan);
    }
}

/// Whether a constant of a law is a stress, or else has no unit.
fn is_stress(key: &str) -> bool {
    let name = key.split('.').next().unwrap_or(key);
    !matches!(
        name,
        "poisson_ratio" | "alpha" | "nu" | "a" | "beta" | "limit" | "locking_stretch"
    )
}

/// Where the scene has a parameter.
fn place(model: &Model<'_>, parameter: &Parameter) -> Result<Place, GoalError> {
    let problem = &model.plan.problem;
    let found = |what: &'static str, place: Option<usize>| {
        place.ok_or_else(|| GoalError::Unknown {
            text: parameter.to_string(),
            what,
        })
    };
    let obstacle = |name: &String| {
        let mut all = problem.obstacles.iter();
        found("obstacle", all.position(|one| one.name == *name))
    };
    Ok(match parameter {
        Parameter::Material { group, constant } => {
            let mut all = problem.scene.materials.iter();
            let index = found("material", all.position(|one| one.group == *group))?;
            Place::Material(index, constant.clone())
        }
        Parameter::Pose {
            obstacle: name,
            axis,
        }
        | Parameter::Push {
            obstacle: name,
            axis,
        } => Place::Pose(obstacle(name)?, usize::from(*axis)),
        Parameter::Shape {
            obstacle: name,
            key,
        } => Place::Shape(obstacle(name)?, key.clone()),
        Parameter::Friction { obstacle: name } => Place::Friction(obstacle(name)?),
        Parameter::Tresca { obstacle: name } => Place::Tresca(obstacle(name)?),
        Parameter::Mesh => return Err(no_number(parameter)),
        Parameter::Load => Place::Load,
        Parameter::Pressure { index } => {
            let is_there = *index < problem.resolved.pressures.len();
            Place::Pressure(found("pressure", is_there.then_some(*index))?)
        }
        Parameter::Traction { item, axis } => {
            let all = &problem.resolved.tractions;
            let named = all.iter().position(|one| one.name.as_ref() == Some(item));
            let numbered = item.parse().ok().filter(|index| *index < all.len());
            let index = found("traction", named.or(numbered))?;
            Place::Traction(index, usize::from(*axis))
        }
        Parameter::BodyForce { axis } => Place::BodyForce(usize::from(*axis)),
        Parameter::Support { support, axis } => {
            let all = &problem.resolved.supports;
            let index = found("support", all.iter().position(|one| one.name == *support))?;
            support_axis(model, parameter, (index, usize::from(*axis)))?
        }
    })
}

/// What is no single number is not changed by a step.
fn no_number(parameter: &Parameter) -> GoalError {
    GoalError::Absent {
        text: parameter.to_string(),
        cause: "places of nodes are no single number".to_owned(),
    }
}

/// Step of a coefficient of friction; a cause where it has no derivative.
fn friction_step((model, state): (&Model<'_>, &State), index: usize) -> Result<f64, &'static str> {
    let is_given = model.plan.problem.obstacles[index].tresca.is_some();
    match state.drive.friction.get(index) {
        _ if is_given => Err("the bound of its tractions is given, not a multiple of the pressure"),
        Some(&value) if value > 0.0 => Ok(OF_CONSTANTS * value),
        _ => Err("the obstacle has no friction there, and which way it would slip is not known"),
    }
}

/// The place of what a support prescribes.
fn support_axis(
    model: &Model<'_>,
    parameter: &Parameter,
    (index, axis): (usize, usize),
) -> Result<Place, GoalError> {
    let support = &model.plan.problem.resolved.supports[index];
    let is_held = support.normal.is_none() && support.displacement[axis].is_some();
    if is_held {
        Ok(Place::Support(index, axis))
    } else {
        Err(GoalError::Absent {
            text: parameter.to_string(),
            cause: "the support does not hold that component".to_owned(),
        })
    }
}
