//! A component of the pose of an obstacle.

use super::super::perturbed::Perturbed;
use super::place::{OF_LENGTHS, Place};
use crate::model::Model;
use crate::model::evaluate::Terms;
use crate::model::push::{Control, Part};
use crate::model::state::State;

/// Of an obstacle, axes 3 to 5 rotations.
pub(super) struct Pose {
    pub(super) index: usize,
    pub(super) axis: usize,
}

impl Place for Pose {
    fn terms(&self) -> Terms {
        Terms::Contact
    }

    fn is_linear(&self, _: &Model<'_>) -> bool {
        false
    }

    fn is_geometric(&self) -> bool {
        true
    }

    fn control(&self) -> Option<Control> {
        Some(Control {
            part: Part::Obstacle(self.index),
            axis: self.axis,
        })
    }

    fn step(&self, (model, _): (&Model<'_>, &State)) -> Result<f64, &'static str> {
        Ok(if self.axis < 3 {
            OF_LENGTHS * model.plan.problem.units.length
        } else {
            OF_LENGTHS
        })
    }

    fn apply(&self, changed: &mut Perturbed<'_>, by: f64) -> Result<(), String> {
        let pose = &mut changed.state.drive.poses[self.index];
        match self.axis.checked_sub(3) {
            None => pose.translation[self.axis] += by,
            Some(about) => pose.rotation[about] += by,
        }
        Ok(())
    }
}
