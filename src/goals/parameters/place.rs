//! What a kind of parameter has to say of itself.

use super::super::perturbed::Perturbed;
use crate::model::Model;
use crate::model::evaluate::Terms;
use crate::model::push::Control;
use crate::model::state::State;

/// Step of what has a size, over it, without unit; chosen: the error of central differences of four values is
/// its fourth power.
pub(super) const OF_CONSTANTS: f64 = 1e-4;
/// Step of a length over that of the body, and of an angle: as short as rounding lets it be, since points of
/// contact that cross a jump of curvature on the way, where an edge is rounded, see both sides of it. Without unit; at 1e-4 a rounded box had
/// derivatives 3 % off (measured against differences of whole solves), at 1e-6 they agree to five digits.
pub(super) const OF_LENGTHS: f64 = 1e-6;

/// Step of what is a stress, in the caller's units.
pub(super) fn stress_step(model: &Model<'_>) -> f64 {
    OF_CONSTANTS * model.plan.problem.units.stress
}

/// A parameter found in the scene.
pub(in crate::goals) trait Place {
    /// The terms of the residuals that depend on it.
    fn terms(&self) -> Terms;

    /// Whether J and R are linear in it at a given state.
    fn is_linear(&self, _model: &Model<'_>) -> bool {
        true
    }

    /// Whether it is a place or a number of an obstacle: its steps are short for the sake of edges, their square is
    /// less than rounding.
    fn is_geometric(&self) -> bool {
        false
    }

    /// The component of a pose that it is, which may follow from a push.
    fn control(&self) -> Option<Control> {
        None
    }

    /// Step of differences, in the caller's units; a cause where there is no derivative.
    fn step(&self, at: (&Model<'_>, &State)) -> Result<f64, &'static str>;

    /// Makes the parameter larger by some amount.
    ///
    /// # Errors
    /// The cause where the law or the shape has no meaning there.
    fn apply(&self, changed: &mut Perturbed<'_>, by: f64) -> Result<(), String>;
}
