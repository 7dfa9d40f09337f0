//! Pressures of the scene that follow the deformed faces, at a state and a load
//! factor t, non-dimensional:
//!
//! ```text
//! f(v) = - t sum_i int p_i n . v da
//! ```
//!
//! and what their change with the displacement takes off the stiffness. Cost: that
//! of [`crate::assembly::follower`]; nothing in a scene without pressures.

use super::state::State;
use crate::assembly::follower::{
    FollowerPressure, PressedBody, PressureValues, SurfaceMeasure, add_follower_load,
    follower_tangent,
};
use crate::linalg::SparseRows;
use crate::model::Model;
use crate::scene::SceneKind;

/// The body as follower pressures read it, at that displacement in the hierarchical
/// basis.
pub(crate) fn pressed<'a>(model: &Model<'a>, displacement: &'a [f64]) -> PressedBody<'a> {
    PressedBody {
        mesh: model.mesh,
        scale: model.plan.problem.units.coordinate_scale,
        space: &model.prepared.space,
        measure: match model.plan.problem.resolved.kind {
            SceneKind::Solid => SurfaceMeasure::Solid,
            SceneKind::PlaneStrain | SceneKind::PlaneStress => SurfaceMeasure::Plane,
            SceneKind::Axisymmetric => SurfaceMeasure::Axisymmetric,
        },
        displacement,
    }
}

/// The follower pressures at a load factor, non-dimensional.
fn pressures<'a>(model: &Model<'a>, load: f64) -> Vec<FollowerPressure<'a>> {
    let pressures = model.plan.problem.resolved.pressures.iter();
    pressures
        .map(|pressure| FollowerPressure {
            facets: &pressure.facets,
            pressure: PressureValues::Uniform(
                load * pressure.value / model.plan.problem.units.stress,
            ),
        })
        .collect()
}

/// Adds the pressures at load factor `load` to `force`.
pub(crate) fn add_pressures(model: &Model<'_>, displacement: &[f64], load: f64, force: &mut [f64]) {
    if !model.plan.problem.resolved.pressures.is_empty() {
        let body = pressed(model, displacement);
        add_follower_load(&body, &pressures(model, load), force);
    }
}

/// What they take off the stiffness at a state; none where nothing presses.
pub(crate) fn pressure_tangent(model: &Model<'_>, state: &State) -> Option<SparseRows> {
    let prepared = model.prepared;
    let tangent = pressed_tangent(model, state, &prepared.is_held)?;
    Some(prepared.held.project_matrix(tangent))
}

/// The same without rows and columns of what is `held` `[displacement unknowns]`.
pub(crate) fn pressed_tangent(
    model: &Model<'_>,
    state: &State,
    held: &[bool],
) -> Option<SparseRows> {
    let load = state.drive.load;
    let is_pressed = !model.plan.problem.resolved.pressures.is_empty() && load != 0.0;
    is_pressed.then(|| {
        let body = pressed(model, &state.displacement);
        follower_tangent(&body, &pressures(model, load), held)
    })
}
