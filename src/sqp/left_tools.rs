//! Tools that have left the body since the last equilibrium: their pressure is taken off before
//! the first program.
//!
//! ```text
//! left:  G_j > |u| w_j  on all that is closed,   G_j = int psi_j d da,   w_j = int psi_j dA
//! ```
//!
//! |u| the largest displacement: no body springs back further than it is deformed. The work of a
//! pressure on the area that is to close a gap grows with the gap, so that programs which start
//! with it keep contact closed that the tool has left: a pressed block whose ball goes three
//! lengths away takes 764 applications with it, 47 without. Cost: a pass over the multipliers.

use crate::linalg::vector::largest;
use crate::model::Model;
use crate::model::evaluate::Evaluation;
use crate::model::interfaces::Interface;
use crate::model::state::State;
use crate::saddle::Status;

/// Takes off the pressure and tractions of the tools that have left, by the gaps of `now`; whether
/// there are any.
pub(super) fn release(model: &Model<'_>, state: &mut State, now: &Evaluation) -> bool {
    let reach = largest(&state.displacement);
    let mut left = vec![false; state.multiplier.len()];
    for interface in &model.interfaces.list {
        if has_left(interface, (state, now), reach) {
            interface.places().for_each(|place| left[place] = true);
        }
    }
    if let Some(friction) = &model.interfaces.friction {
        let width = friction.components.count();
        for (point, &partner) in friction.partners.iter().enumerate() {
            let first = friction.first + width * point;
            let is_left = left[partner as usize];
            left[first..first + width].fill(is_left);
        }
    }
    for (place, _) in left.iter().enumerate().filter(|(_, left)| **left) {
        state.multiplier[place] = 0.0;
        state.status[place] = Status::Open;
    }
    left.contains(&true)
}

/// Whether a tool pressed, and all that it pressed on is further away than `reach`.
fn has_left(interface: &Interface, (state, now): (&State, &Evaluation), reach: f64) -> bool {
    let weights = interface.surface.weights.iter();
    let closed = interface
        .places()
        .zip(weights)
        .filter(|&(place, _)| state.status[place].is_closed());
    let mut far = closed.map(|(place, weight)| now.gap[place] > reach * weight);
    interface.is_contact() && far.next() == Some(true) && far.all(|is_far| is_far)
}
