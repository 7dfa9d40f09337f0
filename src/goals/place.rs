//! Where a scene has a parameter: which terms of the residuals know it, and the step of its differences.

use super::error::GoalError;
use crate::model::Model;
use crate::model::evaluate::Terms;
use crate::model::state::State;
use crate::scene::numbers::{constant, is_linear, number};
use crate::scene::{MaterialModel, Parameter, SceneKind};

/// Step of a material's constant, over its size, without unit; chosen: the error of central differences
/// of four values is its fourth power.
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
    /// Coefficient of friction of the contact between bodies of that number.
    PairFriction(usize),
    /// Its given bound.
    PairTresca(usize),
    /// Of all loads.
    Load,
    /// Number of the pressure.
    Pressure(usize),
    /// Number of the fluid.
    Fluid(usize),
    /// Number of the traction, axis.
    Traction(usize, usize),
    /// Axis.
    BodyForce(usize),
    /// Number of the support, axis.
    Support(usize, usize),
}

impl Place {
    /// The terms of the residuals that depend on it.
    pub(super) fn terms(&self) -> Terms {
        match self {
            Self::Material(..) => Terms::Body,
            Self::Pose(..)
            | Self::Shape(..)
            | Self::Friction(_)
            | Self::Tresca(_)
            | Self::PairFriction(_)
            | Self::PairTresca(_) => Terms::Contact,
            Self::Load
            | Self::Pressure(_)
            | Self::Fluid(_)
            | Self::Traction(..)
            | Self::BodyForce(_) => Terms::Loads,
            Self::Support(..) => Terms::All,
        }
    }

    /// Whether J and R are linear in it at a given state.
    pub(super) fn is_linear(&self, model: &Model<'_>) -> bool {
        let resolved = &model.plan.problem.resolved;
        match self {
            Self::Material(index, key) => {
                let law = &model.plan.problem.scene.materials[*index].model;
                let is_beside_rubber =
                    model.is_rubber() && !matches!(law, MaterialModel::Rubber { .. });
                resolved.kind != SceneKind::PlaneStress && !is_beside_rubber && is_linear(law, key)
            }
            Self::Load
            | Self::Pressure(_)
            | Self::Fluid(_)
            | Self::Traction(..)
            | Self::BodyForce(_) => true,
            Self::Friction(_) | Self::Tresca(_) => true,
            Self::PairFriction(_) | Self::PairTresca(_) => true,
            Self::Support(..) => model.is_linear(),
            Self::Pose(..) | Self::Shape(..) => false,
        }
    }

    /// Whether it is a place or a number of an obstacle: its steps are short for the sake of edges, their square is
    /// less than rounding.
    pub(super) fn is_geometric(&self) -> bool {
        matches!(self, Self::Pose(..) | Self::Shape(..))
    }

    /// Step of differences, in the caller's units; a cause where there is no derivative.
    pub(super) fn step(&self, (model, state): (&Model<'_>, &State)) -> Result<f64, &'static str> {
        let units = &model.plan.problem.units;
        let length = OF_LENGTHS * units.length;
        Ok(match self {
            Self::Material(index, key) => of_constant(model, (*index, key))?,
            Self::Shape(index, key) => of_shape(model, (*index, key))?,
            Self::Pose(_, axis) if *axis >= 3 => OF_LENGTHS,
            Self::Pose(..) | Self::Support(..) => length,
            Self::Load => OF_CONSTANTS * state.drive.load.abs().max(1.0),
            Self::Friction(index) => friction_step((model, state), *index)?,
            Self::Tresca(index) if model.plan.problem.obstacles[*index].tresca.is_none() => {
                return Err("the obstacle has no bound on its tractions");
            }
            Self::PairFriction(index) => pair_friction_step(model, *index)?,
            Self::PairTresca(index) if model.plan.problem.pairs[*index].tresca.is_none() => {
                return Err("the contact has no bound on its tractions");
            }
            Self::Pressure(_)
            | Self::Fluid(_)
            | Self::Traction(..)
            | Self::Tresca(_)
            | Self::PairTresca(_) => OF_CONSTANTS * units.stress,
            Self::BodyForce(_) => OF_CONSTANTS * units.body_force(),
        })
    }
}

/// Step of a constant of a law.
fn of_constant(model: &Model<'_>, (index, key): (usize, &str)) -> Result<f64, &'static str> {
    let (scene, units) = (&model.plan.problem.scene, &model.plan.problem.units);
    let mut law = scene.materials[index].model.clone();
    let found = constant(&mut law, key);
    let value = *found.ok_or("the law has no such finite constant")?;
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
        return Err(
            "one half is the end of its range: it has no derivative from both sides; ask for \
             the modulus",
        );
    }
    Ok(room.min(OF_CONSTANTS * size))
}

/// Step of a number of a shape.
fn of_shape(model: &Model<'_>, (index, key): (usize, &str)) -> Result<f64, &'static str> {
    let scene = &model.plan.problem.scene;
    let length = OF_LENGTHS * model.plan.problem.units.length;
    let mut shape = scene.obstacles[index].shape.clone();
    let found = number(&mut shape, key);
    let value = *found.ok_or("the shape has no such number")?;
    Ok(match key {
        "angle" => OF_LENGTHS,
        key if key.starts_with("normal") || key.starts_with("axis") => OF_LENGTHS,
        _ if value > 0.0 => length.min(OF_LENGTHS * value),
        _ => length,
    })
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
pub(super) fn place(model: &Model<'_>, parameter: &Parameter) -> Result<Place, GoalError> {
    let named = Named { model, parameter };
    let problem = &model.plan.problem;
    Ok(match parameter {
        Parameter::Material { group, constant } => {
            let mut all = problem.scene.materials.iter();
            let index = named.found("material", all.position(|one| one.group == *group))?;
            Place::Material(index, constant.clone())
        }
        Parameter::Pose {
            obstacle: name,
            axis,
        }
        | Parameter::Push {
            obstacle: name,
            axis,
        } => Place::Pose(named.obstacle(name)?, usize::from(*axis)),
        Parameter::Shape {
            obstacle: name,
            key,
        } => Place::Shape(named.obstacle(name)?, key.clone()),
        Parameter::Friction { obstacle: name } => Place::Friction(named.obstacle(name)?),
        Parameter::Tresca { obstacle: name } => Place::Tresca(named.obstacle(name)?),
        Parameter::ContactFriction { contact } => Place::PairFriction(named.pair(contact)?),
        Parameter::ContactTresca { contact } => Place::PairTresca(named.pair(contact)?),
        Parameter::Mesh => return Err(no_number(parameter)),
        Parameter::Load => Place::Load,
        Parameter::Pressure { index } => {
            let is_there = *index < problem.resolved.pressures.len();
            Place::Pressure(named.found("pressure", is_there.then_some(*index))?)
        }
        Parameter::Fluid { fluid } => {
            let mut all = problem.resolved.fluids.iter();
            Place::Fluid(named.found("fluid", all.position(|one| one.name == *fluid))?)
        }
        Parameter::Traction { item, axis } => {
            let index = named.found("traction", traction(model, item))?;
            Place::Traction(index, usize::from(*axis))
        }
        Parameter::BodyForce { axis } => Place::BodyForce(usize::from(*axis)),
        Parameter::SupportPush {
            support: name,
            axis,
        } => Place::Support(named.support(name)?, usize::from(*axis)),
        Parameter::Support {
            support: name,
            axis,
        } => {
            let index = named.support(name)?;
            support_axis(model, parameter, (index, usize::from(*axis)))?
        }
    })
}

/// The things that a parameter names.
struct Named<'a> {
    model: &'a Model<'a>,
    parameter: &'a Parameter,
}

impl Named<'_> {
    fn found(&self, what: &'static str, place: Option<usize>) -> Result<usize, GoalError> {
        place.ok_or_else(|| GoalError::Unknown {
            text: self.parameter.to_string(),
            what,
        })
    }

    fn obstacle(&self, name: &str) -> Result<usize, GoalError> {
        let mut all = self.model.plan.problem.obstacles.iter();
        self.found("obstacle", all.position(|one| one.name == name))
    }

    fn support(&self, name: &str) -> Result<usize, GoalError> {
        let mut all = self.model.plan.problem.resolved.supports.iter();
        self.found("support", all.position(|one| one.name == name))
    }

    fn pair(&self, name: &str) -> Result<usize, GoalError> {
        let mut all = self.model.plan.problem.pairs.iter();
        self.found("contact", all.position(|one| one.name == name))
    }
}

/// Number of a traction by its name or its place.
fn traction(model: &Model<'_>, item: &str) -> Option<usize> {
    let all = &model.plan.problem.resolved.tractions;
    let named = all.iter().position(|one| one.name.as_deref() == Some(item));
    named.or_else(|| item.parse().ok().filter(|index| *index < all.len()))
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

/// The same of a contact between bodies.
fn pair_friction_step(model: &Model<'_>, index: usize) -> Result<f64, &'static str> {
    let pair = &model.plan.problem.pairs[index];
    match pair.tresca {
        Some(_) => Err("the bound of its tractions is given, not a multiple of the pressure"),
        None if pair.friction > 0.0 => Ok(OF_CONSTANTS * pair.friction),
        None => Err("the contact has no friction, and which way it would slip is not known"),
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
