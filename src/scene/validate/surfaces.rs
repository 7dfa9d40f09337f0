//! Supports, tractions and pressures: names, groups, values.

use super::support_load::Poses;
use super::{Faults, Placed, ResolvedPressure, ResolvedTraction, in_plane, names, values};
use crate::mesh::Mesh;
use crate::scene::{Profile, Scene, Support};

/// The supports on their facets.
pub(crate) fn supports<'a>(
    scene: &'a Scene,
    mesh: &Mesh,
    faults: &mut Faults,
) -> Vec<Placed<'a, Support>> {
    let all = scene.supports.iter().map(|support| support.name.as_str());
    names::check_unique(faults, "support", all);
    scene
        .supports
        .iter()
        .map(|support| {
            let path = format!("support.{}", support.name);
            if support.held().iter().all(Option::is_none) && support.normal.is_none() {
                faults.add(format!("{path}.displacement"), "holds no component");
            }
            let values = support.displacement.map(|value| value.unwrap_or(0.0));
            faults.finite(&format!("{path}.displacement"), &values);
            in_plane(faults, mesh, &format!("{path}.displacement.z"), values);
            Poses { scene, mesh }.check_load(support, &path, faults);
            let on = format!("{path}.on");
            let facets = names::facets(mesh, &on, &support.on, faults);
            if let Some(value) = support.normal {
                normal(support, value, &path, faults);
                names::refuse_inner_facets(mesh, &facets, on, faults);
            }
            Placed {
                item: support,
                facets,
            }
        })
        .collect()
}

/// A normal component stands alone and is the same everywhere.
fn normal(support: &Support, value: f64, path: &str, faults: &mut Faults) {
    let path = format!("{path}.normal");
    faults.finite(&path, &[value]);
    if support.displacement.iter().any(Option::is_some) {
        let message = "stands beside `displacement`: give the normal component or components";
        faults.add(&path, message);
    }
    if support.profile != Profile::Constant {
        faults.add(path, "stands beside `profile`, which varies components");
    }
}

/// The tractions on their facets.
pub(crate) fn tractions(scene: &Scene, mesh: &Mesh, faults: &mut Faults) -> Vec<ResolvedTraction> {
    let named = scene.tractions.iter().filter_map(|one| one.name.as_deref());
    names::check_unique(faults, "traction", named);
    scene
        .tractions
        .iter()
        .enumerate()
        .map(|(index, traction)| {
            let path = match &traction.name {
                Some(name) => format!("traction.{name}"),
                None => format!("traction[{index}]"),
            };
            faults.finite(&format!("{path}.value"), &traction.value);
            in_plane(faults, mesh, &format!("{path}.value"), traction.value);
            let on = format!("{path}.on");
            let facets = names::facets(mesh, &on, &traction.on, faults);
            ResolvedTraction {
                name: traction.name.clone(),
                values: values::of_traction((traction, &path), (&facets, mesh), faults),
                facets,
                value: traction.value,
            }
        })
        .collect()
}

/// The follower pressures on their facets.
pub(crate) fn pressures(scene: &Scene, mesh: &Mesh, faults: &mut Faults) -> Vec<ResolvedPressure> {
    scene
        .pressures
        .iter()
        .enumerate()
        .map(|(index, pressure)| {
            let path = format!("pressure[{index}]");
            faults.finite(&format!("{path}.value"), &[pressure.value]);
            let on = format!("{path}.on");
            let facets = names::facets(mesh, &on, &pressure.on, faults);
            names::refuse_inner_facets(mesh, &facets, on, faults);
            ResolvedPressure {
                facets,
                value: pressure.value,
            }
        })
        .collect()
}
