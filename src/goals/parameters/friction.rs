//! Coefficients of friction and given bounds of tractions, of obstacles and of contacts between bodies.

use super::super::perturbed::Perturbed;
use super::place::{OF_CONSTANTS, Place, stress_step};
use crate::model::Model;
use crate::model::evaluate::Terms;
use crate::model::state::State;

/// What rubs, by its number.
#[derive(Clone, Copy)]
pub(super) enum Rubbing {
    Obstacle(usize),
    Contact(usize),
}

impl Rubbing {
    /// Its given bound.
    fn bound(self, model: &Model<'_>) -> Option<f64> {
        let problem = &model.plan.problem;
        match self {
            Self::Obstacle(index) => problem.obstacles[index].tresca,
            Self::Contact(index) => problem.pairs[index].tresca,
        }
    }

    /// Its coefficient; that of an obstacle is led.
    fn coefficient(self, (model, state): (&Model<'_>, &State)) -> f64 {
        match self {
            Self::Obstacle(index) => state.drive.friction.get(index).copied().unwrap_or(0.0),
            Self::Contact(index) => model.plan.problem.pairs[index].friction,
        }
    }
}

/// Of friction: traction at most a multiple of the pressure.
pub(super) struct Coefficient(pub(super) Rubbing);

impl Place for Coefficient {
    fn terms(&self) -> Terms {
        Terms::Contact
    }

    fn step(&self, at: (&Model<'_>, &State)) -> Result<f64, &'static str> {
        let value = self.0.coefficient(at);
        match self.0.bound(at.0) {
            Some(_) => Err("the bound of its tractions is given, not a multiple of the pressure"),
            None if value > 0.0 => Ok(OF_CONSTANTS * value),
            None => Err("it has no friction there, and which way it would slip is not known"),
        }
    }

    fn apply(&self, changed: &mut Perturbed<'_>, by: f64) -> Result<(), String> {
        match self.0 {
            Rubbing::Obstacle(index) => changed.state.drive.friction[index] += by,
            Rubbing::Contact(index) => changed.plan_mut().problem.pairs[index].friction += by,
        }
        Ok(())
    }
}

/// A given bound.
pub(super) struct Tresca(pub(super) Rubbing);

impl Place for Tresca {
    fn terms(&self) -> Terms {
        Terms::Contact
    }

    fn step(&self, (model, _): (&Model<'_>, &State)) -> Result<f64, &'static str> {
        let bound = self.0.bound(model);
        bound.ok_or("it has no given bound on its tractions")?;
        Ok(stress_step(model))
    }

    fn apply(&self, changed: &mut Perturbed<'_>, by: f64) -> Result<(), String> {
        let problem = &mut changed.plan_mut().problem;
        let bound = match self.0 {
            Rubbing::Obstacle(index) => &mut problem.obstacles[index].tresca,
            Rubbing::Contact(index) => &mut problem.pairs[index].tresca,
        };
        bound.iter_mut().for_each(|bound| *bound += by);
        Ok(())
    }
}
