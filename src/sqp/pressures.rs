//! Pressures of the scene that follow the deformed faces, at a state and a load
//! factor t, non-dimensional:
//!
//! ```text
//! f(v) = - t sum_i int p_i n . v da
//! ```
//!
//! and what their change with the displacement takes off the stiffness. Cost: that
//! of [`crate::assembly::follower`]; nothing in a scene without pressures.

use super::evaluate::Context;
use crate::assembly::follower::{
    FollowerPressure, PressedBody, SurfaceMeasure, add_follower_load, follower_tangent,
};
use crate::linalg::SparseRows;
use crate::scene::SceneKind;

fn pressed<'a>(context: &Context<'a>, displacement: &'a [f64]) -> PressedBody<'a> {
    PressedBody {
        mesh: context.mesh,
        scale: context.plan.units.coordinate_scale,
        space: &context.prepared.space,
        measure: match context.plan.resolved.kind {
            SceneKind::Solid => SurfaceMeasure::Solid,
            SceneKind::PlaneStrain => SurfaceMeasure::Plane,
            SceneKind::Axisymmetric => SurfaceMeasure::Axisymmetric,
        },
        displacement,
    }
}

fn pressures<'a>(context: &Context<'a>, load: f64) -> Vec<FollowerPressure<'a>> {
    let given = context.plan.scene.pressures.iter();
    let pressures = given.zip(&context.plan.resolved.pressure_facets);
    pressures
        .map(|(pressure, facets)| FollowerPressure {
            facets,
            pressure: load * pressure.value / context.plan.units.stress,
        })
        .collect()
}

/// Adds the pressures at load factor `load` to `force`.
pub(super) fn add_pressures(
    context: &Context<'_>,
    displacement: &[f64],
    load: f64,
    force: &mut [f64],
) {
    if !context.plan.scene.pressures.is_empty() {
        let body = pressed(context, displacement);
        add_follower_load(&body, &pressures(context, load), force);
    }
}

/// What they take off the stiffness; none where nothing presses.
pub(super) fn pressure_tangent(
    context: &Context<'_>,
    displacement: &[f64],
    load: f64,
) -> Option<SparseRows> {
    let is_pressed = !context.plan.scene.pressures.is_empty() && load != 0.0;
    is_pressed.then(|| {
        let body = pressed(context, displacement);
        follower_tangent(&body, &pressures(context, load), &context.prepared.is_held)
    })
}
