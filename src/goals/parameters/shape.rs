//! A number of the shape of an obstacle: a radius, an angle, a component of a point.

use super::super::perturbed::Perturbed;
use super::place::{OF_LENGTHS, Place};
use crate::model::Model;
use crate::model::evaluate::Terms;
use crate::model::state::State;
use crate::scene::numbers::number;

/// The number `key` of the shape of an obstacle.
pub(super) struct ShapeNumber {
    pub(super) index: usize,
    pub(super) key: String,
}

impl Place for ShapeNumber {
    fn terms(&self) -> Terms {
        Terms::Contact
    }

    fn is_linear(&self, _: &Model<'_>) -> bool {
        false
    }

    fn is_geometric(&self) -> bool {
        true
    }

    fn step(&self, (model, _): (&Model<'_>, &State)) -> Result<f64, &'static str> {
        let problem = &model.plan.problem;
        let length = OF_LENGTHS * problem.units.length;
        let mut shape = problem.scene.obstacles[self.index].shape.clone();
        let found = number(&mut shape, &self.key);
        let value = *found.ok_or("the shape has no such number")?;
        Ok(match self.key.as_str() {
            "angle" => OF_LENGTHS,
            key if key.starts_with("normal") || key.starts_with("axis") => OF_LENGTHS,
            _ if value > 0.0 => length.min(OF_LENGTHS * value),
            _ => length,
        })
    }

    fn apply(&self, changed: &mut Perturbed<'_>, by: f64) -> Result<(), String> {
        let problem = &mut changed.plan_mut().problem;
        let shape = &mut problem.scene.obstacles[self.index].shape;
        if let Some(value) = number(shape, &self.key) {
            *value += by;
        }
        let built = shape.build(problem.units.length);
        let built = built.map_err(|error| error.to_string())?;
        problem.obstacles[self.index].shape = built.clone();
        let interfaces = changed.base.interfaces.with_shape(self.index, built);
        changed.interfaces = Some(interfaces);
        Ok(())
    }
}
