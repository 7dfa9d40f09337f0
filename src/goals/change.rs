//! A parameter with the step of its differences.

use super::error::GoalError;
use super::parameters::place;
use super::parameters::place::Place;
use super::perturbed::Perturbed;
use crate::model::Model;
use crate::model::state::State;
use crate::scene::Parameter;

/// How many times longer steps are of what residuals are linear in: with less rounding. Without unit;
/// chosen.
const OF_LINEAR: f64 = 10.0;

/// A parameter with what it is changed by.
pub(super) struct Change {
    pub(super) place: Box<dyn Place>,
    /// The parameter as it was named.
    text: String,
    /// In the caller's units.
    pub(super) step: f64,
    /// Whether J and R are linear in it at a given state.
    pub(super) is_linear: bool,
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
        let mut changed = Perturbed::new(model, state.clone());
        self.place
            .apply(&mut changed, by)
            .map_err(|cause| GoalError::Absent {
                text: self.text.clone(),
                cause,
            })?;
        Ok(changed)
    }
}
