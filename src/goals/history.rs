//! Which states depend on their way.
//!
//! Nodes that a fluid wets are a set like that of closed contacts: the same near the state, so that
//! derivatives are those between two changes of it. Friction counts slip from where the increment began. The equations of the last increment, with
//! that place given, have a dual solution like any others, and its error by the mesh; but what of the
//! place depends on a parameter they do not know. They do not need to where the increment began at
//! rest, or where nothing asks for the slip: where nothing sticks, and in the plane what slips goes one
//! way or the other.

use super::error::GoalError;
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::friction::{Friction, SlipStart};
use crate::model::state::State;
use crate::saddle::{Components, Status};

/// Refuses bodies whose state depends on its way where derivatives are asked for.
pub(super) fn refuse_history(
    (model, state): (&Model<'_>, &State),
    asks_for_derivatives: bool,
) -> Result<(), GoalError> {
    let Some(friction) = &model.interfaces.friction else {
        return Ok(());
    };
    let Some(start) = &model.conditions.slip_start else {
        return Err(GoalError::UnknownStart);
    };
    let depends = asks_for_derivatives
        && !began_at_rest(model, start)
        && asks_for_slips(friction, (model, state));
    if depends {
        Err(GoalError::NeedsHistory)
    } else {
        Ok(())
    }
}

/// Whether nothing had moved where the increment began.
fn began_at_rest(model: &Model<'_>, start: &SlipStart) -> bool {
    let is_zero = |values: &[f64]| values.iter().all(|&value| value == 0.0);
    is_zero(start.displacement())
        && is_zero(start.residue().as_flattened())
        && start.drive().poses == Drive::undeformed(model.plan).poses
}

/// Whether the law of friction reads the slip of any point.
fn asks_for_slips(friction: &Friction, (model, state): (&Model<'_>, &State)) -> bool {
    let law = friction.law(model.plan, &state.drive);
    let radii = law.radii(&state.multiplier);
    let width = law.components.count();
    radii.iter().enumerate().any(|(number, radius)| {
        *radius > 0.0
            && match state.status[law.normals + number * width] {
                Status::Open => false,
                Status::Stick => true,
                Status::Slip => law.components == Components::Two,
            }
    })
}
