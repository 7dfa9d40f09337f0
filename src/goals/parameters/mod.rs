//! What derivatives are taken by: for each kind of parameter which terms of the residuals know it, the step
//! of its differences, and the body where it is another.
//!
//! Of dJ/dt = d/dt [J(x, t) + y . R(x, t)] at fixed x ([`gradient`](super::gradient)) a parameter t knows
//! what of J and R it touches; units are the caller's. One file a kind.

mod friction;
mod loads;
mod material;
pub(super) mod place;
mod pose;
mod shape;
mod support;

use super::error::GoalError;
use crate::model::Model;
use crate::scene::Parameter;
use friction::{Coefficient, Rubbing, Tresca};
use loads::{BodyForce, Fluid, Load, Pressure, Traction};
use material::Material;
use place::Place;
use pose::Pose;
use shape::ShapeNumber;
use support::Support;

/// Where the scene has a parameter.
///
/// # Errors
/// [`GoalError::Unknown`] and [`GoalError::Absent`].
pub(super) fn place(model: &Model<'_>, parameter: &Parameter) -> Result<Box<dyn Place>, GoalError> {
    let named = Named { model, parameter };
    Ok(match parameter {
        Parameter::Material { group, constant } => Box::new(Material {
            index: named.material(group)?,
            key: constant.clone(),
        }),
        Parameter::Pose { obstacle, axis } | Parameter::Push { obstacle, axis } => Box::new(Pose {
            index: named.obstacle(obstacle)?,
            axis: usize::from(*axis),
        }),
        Parameter::Shape { obstacle, key } => Box::new(ShapeNumber {
            index: named.obstacle(obstacle)?,
            key: key.clone(),
        }),
        Parameter::Friction { obstacle } => {
            Box::new(Coefficient(Rubbing::Obstacle(named.obstacle(obstacle)?)))
        }
        Parameter::Tresca { obstacle } => {
            Box::new(Tresca(Rubbing::Obstacle(named.obstacle(obstacle)?)))
        }
        Parameter::ContactFriction { contact } => {
            Box::new(Coefficient(Rubbing::Contact(named.pair(contact)?)))
        }
        Parameter::ContactTresca { contact } => {
            Box::new(Tresca(Rubbing::Contact(named.pair(contact)?)))
        }
        Parameter::Mesh => return Err(named.absent("places of nodes are no single number")),
        Parameter::Load => Box::new(Load),
        Parameter::Pressure { index } => Box::new(Pressure(named.pressure(*index)?)),
        Parameter::Fluid { fluid } => Box::new(Fluid(named.fluid(fluid)?)),
        Parameter::Traction { item, axis } => Box::new(Traction {
            index: named.traction(item)?,
            axis: usize::from(*axis),
        }),
        Parameter::BodyForce { axis } => Box::new(BodyForce(usize::from(*axis))),
        Parameter::SupportPush { support, axis } => Box::new(Support {
            index: named.support(support)?,
            axis: usize::from(*axis),
        }),
        Parameter::Support { support, axis } => {
            Box::new(named.held((named.support(support)?, usize::from(*axis)))?)
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

    fn absent(&self, cause: &str) -> GoalError {
        GoalError::Absent {
            text: self.parameter.to_string(),
            cause: cause.to_owned(),
        }
    }

    fn material(&self, group: &str) -> Result<usize, GoalError> {
        let mut all = self.model.plan.problem.scene.materials.iter();
        self.found("material", all.position(|one| one.group == group))
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

    fn pressure(&self, index: usize) -> Result<usize, GoalError> {
        let is_there = index < self.model.plan.problem.resolved.pressures.len();
        self.found("pressure", is_there.then_some(index))
    }

    fn fluid(&self, name: &str) -> Result<usize, GoalError> {
        let mut all = self.model.plan.problem.resolved.fluids.iter();
        self.found("fluid", all.position(|one| one.name == name))
    }

    /// Number of a traction by its name or its place.
    fn traction(&self, item: &str) -> Result<usize, GoalError> {
        let all = &self.model.plan.problem.resolved.tractions;
        let named = all.iter().position(|one| one.name.as_deref() == Some(item));
        let by_place = || item.parse().ok().filter(|index| *index < all.len());
        self.found("traction", named.or_else(by_place))
    }

    /// What a support prescribes.
    fn held(&self, (index, axis): (usize, usize)) -> Result<Support, GoalError> {
        let support = &self.model.plan.problem.resolved.supports[index];
        if support.normal.is_none() && support.displacement[axis].is_some() {
            Ok(Support { index, axis })
        } else {
            Err(self.absent("the support does not hold that component"))
        }
    }
}
