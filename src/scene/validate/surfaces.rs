//! Supports, tractions and pressures: names, groups, values.

use super::{Faults, in_plane, names};
use crate::mesh::{GroupKind, Mesh};
use crate::scene::Scene;

/// Facets of each support.
pub(crate) fn supports(scene: &Scene, mesh: &Mesh, faults: &mut Faults) -> Vec<Vec<u32>> {
    let all = scene.supports.iter().map(|support| support.name.as_str());
    names::check_unique(faults, "support", all);
    scene
        .supports
        .iter()
        .map(|support| {
            let path = format!("support.{}", support.name);
            if support.displacement.iter().all(Option::is_none) {
                faults.add(format!("{path}.displacement"), "holds no component");
            }
            let values = support.displacement.map(|value| value.unwrap_or(0.0));
            faults.finite(&format!("{path}.displacement"), &values);
            in_plane(faults, mesh, &format!("{path}.displacement.z"), values);
            names::members(
                mesh,
                GroupKind::Facets,
                &format!("{path}.on"),
                &support.on,
                faults,
            )
        })
        .collect()
}

/// Facets of each traction.
pub(crate) fn tractions(scene: &Scene, mesh: &Mesh, faults: &mut Faults) -> Vec<Vec<u32>> {
    scene
        .tractions
        .iter()
        .enumerate()
        .map(|(index, traction)| {
            let path = format!("traction[{index}]");
            faults.finite(&format!("{path}.value"), &traction.value);
            in_plane(faults, mesh, &format!("{path}.value"), traction.value);
            names::members(
                mesh,
                GroupKind::Facets,
                &format!("{path}.on"),
                &traction.on,
                faults,
            )
        })
        .collect()
}

/// Facets of each follower pressure.
pub(crate) fn pressures(scene: &Scene, mesh: &Mesh, faults: &mut Faults) -> Vec<Vec<u32>> {
    scene
        .pressures
        .iter()
        .enumerate()
        .map(|(index, pressure)| {
            let path = format!("pressure[{index}]");
            faults.finite(&format!("{path}.value"), &[pressure.value]);
            let on = format!("{path}.on");
            let facets = names::members(mesh, GroupKind::Facets, &on, &pressure.on, faults);
            names::refuse_inner_facets(mesh, &facets, on, faults);
            facets
        })
        .collect()
}
