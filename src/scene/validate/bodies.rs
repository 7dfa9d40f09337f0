//! Body force, manufactured field, probes.

use super::{Faults, ResolvedProbe, in_plane, names};
use crate::element::manufactured::Manufactured;
use crate::mesh::Mesh;
use crate::mesh::locate::Locator;
use crate::scene::names::hint;
use crate::scene::{MaterialModel, Profile, Scene, Support};

/// Checks the body force.
pub(crate) fn body_force(scene: &Scene, mesh: &Mesh, faults: &mut Faults) {
    faults.finite("body_force.value", &scene.body_force);
    in_plane(faults, mesh, "body_force.value", scene.body_force);
}

/// Values do not stand beside an analytic field.
pub(crate) fn refuse_values(scene: &Scene, faults: &mut Faults) {
    let supports = scene.supports.iter().any(|one| one.values.is_some());
    let tractions = scene.tractions.iter().any(|one| one.values.is_some());
    if !supports && !tractions && scene.body_force_values.is_none() {
        return;
    }
    if scene.manufactured.is_some() {
        let message = "brings its own loads and values: leave out `values`";
        faults.add("manufactured.field", message);
    }
}

/// The analytic field; its loads take the place of all others.
pub(crate) fn manufactured(
    scene: &Scene,
    mesh: &Mesh,
    faults: &mut Faults,
) -> Option<Manufactured> {
    let name = scene.manufactured.as_deref()?;
    let path = "manufactured.field";
    let others = !scene.tractions.is_empty()
        || !scene.pressures.is_empty()
        || !scene.obstacles.is_empty()
        || scene.body_force.iter().any(|&x| x != 0.0);
    if others {
        faults.add(
            path,
            "brings its own loads: leave out traction, pressure, body_force and obstacle",
        );
    }
    let moved = scene.supports.iter().find(|support| {
        let values = support.displacement.iter().flatten();
        values.copied().any(|value| value.abs() > 0.0)
    });
    if let Some(support) = moved {
        let key = format!("support.{}.displacement", support.name);
        faults.add(
            key,
            "the manufactured field prescribes the values: give zeros",
        );
    }
    let shaped = |support: &&Support| support.profile != Profile::Constant;
    if let Some(support) = scene.supports.iter().find(shaped) {
        let key = format!("support.{}.profile", support.name);
        faults.add(key, "the manufactured field prescribes the values");
    }
    let incompressible = scene.materials.iter().all(|material| match material.model {
        MaterialModel::LinearElastic { poisson_ratio, .. } => poisson_ratio >= 0.5,
        MaterialModel::Stokes { .. } => true,
        MaterialModel::Rubber { bulk_modulus, .. } => bulk_modulus.is_none(),
    });
    if !incompressible {
        faults.add(
            path,
            "the fields are incompressible: set poisson_ratio = 0.5",
        );
    }
    let dimension = mesh.cell_kind().dimension();
    let field = Manufactured::from_name(name, dimension);
    if field.is_none() {
        let hint = hint(name, Manufactured::names().iter().copied());
        faults.add(
            path,
            format!("no field `{name}` in {dimension} dimensions{hint}"),
        );
    }
    field
}

/// Finds the probes in the body.
pub(crate) fn probes(scene: &Scene, mesh: &Mesh, faults: &mut Faults) -> Vec<ResolvedProbe> {
    names::check_unique(
        faults,
        "probe",
        scene.probes.iter().map(|probe| probe.name.as_str()),
    );
    if scene.probes.is_empty() {
        return Vec::new();
    }
    let scale = scene.mesh_scale.unwrap_or(1.0);
    let scale_is_usable = scale > 0.0 && scale.is_finite();
    let locator = Locator::new(mesh);
    let mut found = Vec::new();
    for probe in &scene.probes {
        let path = format!("probe.{}.point", probe.name);
        if !faults.finite(&path, &probe.point) {
            continue;
        }
        match locator.find(mesh, probe.point.map(|x| x / scale)) {
            Some(place) => found.push(ResolvedProbe {
                name: probe.name.clone(),
                place,
            }),
            // A faulty scale has its own message.
            None if !scale_is_usable => (),
            None => faults.add(path, format!("{:?} lies outside the body", probe.point)),
        }
    }
    found
}
