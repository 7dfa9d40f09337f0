//! A component of the displacement that a support prescribes.

use super::super::perturbed::Perturbed;
use super::place::{OF_LENGTHS, Place};
use crate::model::Model;
use crate::model::evaluate::Terms;
use crate::model::prescribed::prescribe;
use crate::model::push::{Control, Part};
use crate::model::state::State;

/// Of a support along an axis.
pub(super) struct Support {
    pub(super) index: usize,
    pub(super) axis: usize,
}

impl Place for Support {
    fn terms(&self) -> Terms {
        Terms::All
    }

    fn is_linear(&self, model: &Model<'_>) -> bool {
        model.is_linear()
    }

    fn control(&self) -> Option<Control> {
        Some(Control {
            part: Part::Support(self.index),
            axis: self.axis,
        })
    }

    fn step(&self, (model, _): (&Model<'_>, &State)) -> Result<f64, &'static str> {
        Ok(OF_LENGTHS * model.plan.problem.units.length)
    }

    fn apply(&self, changed: &mut Perturbed<'_>, by: f64) -> Result<(), String> {
        let state = &mut changed.state;
        state.drive.supports[self.index][self.axis] += by;
        prescribe(changed.base, &state.drive, &mut state.displacement);
        Ok(())
    }
}
