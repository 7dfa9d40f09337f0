//! Displacement and its gradient at points of cells, non-dimensional:
//!
//! ```text
//! u = sum l_a u_a + sum 4 l_a l_b c_ab,   du_i/dx_j,   u_x / x in the place of du_z/dz about an axis
//! ```
//!
//! Points are barycentric coordinates `[4]` of a cell. Cost: some 100 flops.

use super::Model;
use super::state::State;
use crate::geometry::Matrix3;
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
    let corners = model.mesh.corners(cell);
    let sum: f64 = corners.iter().zip(barycentric).map(|(x, l)| l * x[0]).sum();
    model.plan.units.coordinate_scale * sum
}
