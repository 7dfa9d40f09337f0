//! Loads: their factor, pressures, fluids, tractions, body force.

use super::super::perturbed::Perturbed;
use super::place::{OF_CONSTANTS, Place, stress_step};
use crate::model::Model;
use crate::model::evaluate::Terms;
use crate::model::state::State;

/// The factor of all loads.
pub(super) struct Load;

impl Place for Load {
    fn terms(&self) -> Terms {
        Terms::Loads
    }

    fn step(&self, (_, state): (&Model<'_>, &State)) -> Result<f64, &'static str> {
        Ok(OF_CONSTANTS * state.drive.load.abs().max(1.0))
    }

    fn apply(&self, changed: &mut Perturbed<'_>, by: f64) -> Result<(), String> {
        changed.state.drive.load += by;
        Ok(())
    }
}

/// A pressure, by its number.
pub(super) struct Pressure(pub(super) usize);

impl Place for Pressure {
    fn terms(&self) -> Terms {
        Terms::Loads
    }

    fn step(&self, (model, _): (&Model<'_>, &State)) -> Result<f64, &'static str> {
        Ok(stress_step(model))
    }

    fn apply(&self, changed: &mut Perturbed<'_>, by: f64) -> Result<(), String> {
        changed.plan_mut().problem.resolved.pressures[self.0].value += by;
        Ok(())
    }
}

/// The pressure of a fluid, by its number.
pub(super) struct Fluid(pub(super) usize);

impl Place for Fluid {
    fn terms(&self) -> Terms {
        Terms::Loads
    }

    fn step(&self, (model, _): (&Model<'_>, &State)) -> Result<f64, &'static str> {
        Ok(stress_step(model))
    }

    fn apply(&self, changed: &mut Perturbed<'_>, by: f64) -> Result<(), String> {
        changed.state.drive.fluids[self.0].pressure += by;
        Ok(())
    }
}

/// A component of a traction.
pub(super) struct Traction {
    pub(super) index: usize,
    pub(super) axis: usize,
}

impl Place for Traction {
    fn terms(&self) -> Terms {
        Terms::Loads
    }

    fn step(&self, (model, _): (&Model<'_>, &State)) -> Result<f64, &'static str> {
        Ok(stress_step(model))
    }

    fn apply(&self, changed: &mut Perturbed<'_>, by: f64) -> Result<(), String> {
        let traction = &mut changed.plan_mut().problem.resolved.tractions[self.index];
        traction.value[self.axis] += by;
        changed.prepare_load();
        Ok(())
    }
}

/// A component of the body force.
pub(super) struct BodyForce(pub(super) usize);

impl Place for BodyForce {
    fn terms(&self) -> Terms {
        Terms::Loads
    }

    fn step(&self, (model, _): (&Model<'_>, &State)) -> Result<f64, &'static str> {
        Ok(OF_CONSTANTS * model.plan.problem.units.body_force())
    }

    fn apply(&self, changed: &mut Perturbed<'_>, by: f64) -> Result<(), String> {
        changed.plan_mut().problem.resolved.body_force[self.0] += by;
        changed.prepare_load();
        Ok(())
    }
}
