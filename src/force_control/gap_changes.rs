//! What moving an obstacle does to its gaps and slips: the same as moving the body under it by
//! the opposite motion.
//!
//! ```text
//! dg/dz = C r,   r(x) = e  or  e x (x + u - c),   C = -dg/du with all columns
//! ```
//!
//! r the rigid motion of the body along one axis, hierarchical; c the reference point. Cost:
//! a linearisation of the gaps an obstacle and a sparse product an axis.

use crate::contact::gap::linearise;
use crate::geometry::vector3::{cross, sub};
use crate::linalg::{LinearOperator, Workspace};
use crate::model::Model;
use crate::model::joined::Joined;
use crate::model::push::{Control, Part};
use crate::model::state::State;
use crate::obstacle::Obstacle;

/// D, column by column `[controls][multipliers]`.
pub(super) fn gap_changes(model: &Model<'_>, state: &State, controls: &[Control]) -> Vec<Vec<f64>> {
    let of_one = |own: &[Control]| changes_of_one(model, state, own);
    let by_part = controls.chunk_by(|a, b| a.part == b.part);
    by_part.flat_map(of_one).collect()
}

/// The columns of one obstacle; supports move no gap of themselves.
fn changes_of_one(model: &Model<'_>, state: &State, own: &[Control]) -> Vec<Vec<f64>> {
    let still = || vec![vec![0.0; state.multiplier.len()]; own.len()];
    let Part::Obstacle(number) = own[0].part else {
        return still();
    };
    let Some((interface, met)) = model.placed(&state.drive).nth(number) else {
        return still();
    };
    let Some(obstacle) = met.obstacle() else {
        return still();
    };
    let unknowns = state.displacement.len();
    let free = vec![false; unknowns];
    let body = model.deformed(&state.displacement);
    let mut joined = Joined::new(state.multiplier.len());
    joined.add(interface, linearise(&body, &interface.surface, &met, &free));
    if let Some(friction) = &model.interfaces.friction {
        let mut slips = friction.linearised(model, state, &free);
        let width = friction.components.count();
        let rows = friction.points.iter().zip(slips.rows.chunks_mut(width));
        for (_, rows) in rows.filter(|(point, _)| point.obstacle != number) {
            rows.iter_mut().for_each(Vec::clear);
        }
        joined.add_friction(friction, slips);
    }
    let (_, coupling) = joined.finish(unknowns);
    let about = obstacle.reference_point();
    let column = |control: &Control| {
        let mut change = vec![0.0; state.multiplier.len()];
        let motion = motion(model, state, (control.axis, about));
        coupling.apply(&motion, &mut change, &mut Workspace::new());
        change
    };
    own.iter().map(column).collect()
}

/// r `[displacement]`.
fn motion(model: &Model<'_>, state: &State, (axis, about): (usize, [f64; 3])) -> Vec<f64> {
    let space = &model.prepared.space;
    let c = space.components;
    let mut direction = [0.0; 3];
    direction[axis % 3] = 1.0;
    let mut motion = vec![0.0; state.displacement.len()];
    for (node, own) in motion.chunks_exact_mut(c).enumerate() {
        let moved = match (axis < 3, node < space.vertices) {
            (true, true) => direction,
            // What is linear has no part on edges.
            (true, false) => return motion,
            (false, true) => {
                let place = model.place(node, &state.displacement);
                cross(direction, sub(place, about))
            }
            (false, false) => cross(direction, model.place(node, &state.displacement)),
        };
        own.copy_from_slice(&moved[..c]);
    }
    motion
}
