//! Displacement and its gradient at points of cells, non-dimensional:
//!
//! ```text
//! u = sum l_a u_a + sum 4 l_a l_b c_ab,   du_i/dx_j,   u_x / x in the place of du_z/dz about an axis
//! ```
//!
//! In cells with curved edges the gradient is that on the curved cell.
//!
//! Points are barycentric coordinates `[4]` of a cell. Cost: some 100 flops.

use super::Model;
use super::state::State;
use crate::geometry::Matrix3;
use crate::geometry::tensor::{plus, plus_unit, product};
use crate::scene::validate::ON_AXIS;

/// Displacement `[3]` at a point of a cell.
pub(crate) fn displacement_at(
    model: &Model<'_>,
    state: &State,
    cell: usize,
    barycentric: &[f64; 4],
) -> [f64; 3] {
    let space = &model.prepared.space;
    space.value_at(model.mesh, &state.displacement, cell, barycentric)
}

/// Displacement gradient du_i/dx_j `[3, 3]` at a point of a cell.
pub(crate) fn gradient_at(
    model: &Model<'_>,
    state: &State,
    cell: usize,
    barycentric: &[f64; 4],
) -> Matrix3 {
    let space = &model.prepared.space;
    let hats = model.prepared.geometry.gradients_of(cell);
    let mut gradient =
        space.gradient_at(model.mesh, &state.displacement, (cell, hats), barycentric);
    if let Some(map) = model.prepared.geometry.curves.map(cell, barycentric) {
        gradient = product(&gradient, &map.inverse);
    }
    if model.plan.is_axisymmetric() {
        gradient[2][2] = match radius_at(model, cell, barycentric) {
            radius if radius > ON_AXIS => {
                displacement_at(model, state, cell, barycentric)[0] / radius
            }
            // Its limit.
            _ => gradient[0][0],
        };
    }
    gradient
}

/// Distance x from the axis at a point of a cell.
pub(crate) fn radius_at(model: &Model<'_>, cell: usize, barycentric: &[f64; 4]) -> f64 {
    model.plan.problem.units.coordinate_scale * model.mesh.position_in(cell, barycentric)[0]
}

/// Gradient of the place of a point by that on the straight cell, dx_i/dX_j `[3, 3]`: linear on
/// the cell, one out of the plane.
pub(crate) fn deformation_from_straight(
    model: &Model<'_>,
    state: &State,
    cell: usize,
    barycentric: &[f64; 4],
) -> Matrix3 {
    let geometry = &model.prepared.geometry;
    let space = &model.prepared.space;
    let hats = geometry.gradients_of(cell);
    let mut gradient =
        space.gradient_at(model.mesh, &state.displacement, (cell, hats), barycentric);
    if let Some(curved) = geometry.curves.of(cell) {
        gradient = plus(&gradient, 1.0, &curved.slope_at(barycentric));
    }
    plus_unit(&gradient)
}
