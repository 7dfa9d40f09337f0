//! Cells that a deformation turns inside out: det F below zero somewhere in them, though it is
//! above zero at the points of the rule, which alone the energy sees. No body does that; the
//! mesh is too coarse for what it is asked. Only rubber is looked at.
//!
//! The gradient from the straight to the deformed cell is linear but for the stretch around an axis,
//! so that cells whose Bernstein bound is above zero are passed over ([`crate::element::jacobian`]);
//! the others are looked at on a lattice. Cost: a gradient a corner.

use crate::element::jacobian::least_jacobian_bound;
use crate::geometry::tensor::volume_change;
use crate::model::Model;
use crate::model::state::State;
use crate::model::values::{deformation_from_straight, gradient_at};

/// Parts of an edge of the lattice.
const PARTS: usize = 4;

/// The undeformed point where det F is least, if that is not above zero, in the mesh's lengths.
pub(crate) fn inside_out(model: &Model<'_>, state: &State) -> Option<[f64; 3]> {
    if !model.is_rubber() {
        return None;
    }
    let lattice = lattice(model.mesh.cell_kind().vertices());
    let suspects = (0..model.mesh.cell_count()).filter(|&cell| may_be(model, state, cell));
    let found = suspects.flat_map(|cell| {
        let at = move |place: &[f64; 4]| {
            let gradient = gradient_at(model, state, cell, place);
            (cell, 1.0 + volume_change(&gradient), *place)
        };
        lattice.iter().map(at)
    });
    let worst = found.filter(|(_, jacobian, _)| *jacobian <= 0.0);
    let (cell, _, place) = worst.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(model.mesh.position_in(cell, &place))
}

/// Whether the bound of a cell leaves room for det F below zero.
fn may_be(model: &Model<'_>, state: &State, cell: usize) -> bool {
    let corners = model.mesh.cell_kind().vertices();
    let mut gradients = [[[0.0; 3]; 3]; 4];
    let mut is_turned = false;
    for (corner, gradient) in gradients.iter_mut().enumerate().take(corners) {
        let mut place = [0.0; 4];
        place[corner] = 1.0;
        *gradient = deformation_from_straight(model, state, cell, &place);
        if model.plan.is_axisymmetric() {
            is_turned |= 1.0 + gradient_at(model, state, cell, &place)[2][2] <= 0.0;
        }
    }
    let bound = least_jacobian_bound(&gradients[..corners]);
    is_turned || bound.is_nan() || bound <= 0.0
}

/// Barycentric points of a cell with that number of corners.
fn lattice(corners: usize) -> Vec<[f64; 4]> {
    let mut all = Vec::new();
    let share = |n: usize| n as f64 / PARTS as f64;
    for i in 0..=PARTS {
        for j in 0..=PARTS - i {
            let last = if corners == 4 { PARTS - i - j } else { 0 };
            for k in 0..=last {
                let rest = PARTS - i - j - k;
                all.push(match corners {
                    4 => [share(i), share(j), share(k), share(rest)],
                    _ => [share(i), share(j), share(rest), 0.0],
                });
            }
        }
    }
    all
}
