//! Load steps and obstacle updates.

use super::{Faults, in_plane, names};
use crate::mesh::Mesh;
use crate::scene::{Scene, SceneError, Step};

/// Most increments in one step.
const MOST_INCREMENTS: u32 = 100_000;

/// Checks one step on its own.
pub(crate) fn check_step(scene: &Scene, step: &Step, mesh: &Mesh) -> Result<(), SceneError> {
    let mut faults = Faults::default();
    check(scene, step, "step", mesh, &mut faults);
    faults.result()
}

/// Adds the faults of one step.
pub(crate) fn check(scene: &Scene, step: &Step, path: &str, mesh: &Mesh, faults: &mut Faults) {
    if !(1..=MOST_INCREMENTS).contains(&step.increments) {
        let message = format!(
            "must lie between 1 and {MOST_INCREMENTS}, not {}",
            step.increments
        );
        faults.add(format!("{path}.increments"), message);
    }
    if let Some(load) = step.load {
        faults.finite(&format!("{path}.load"), &[load]);
    }
    for target in &step.obstacles {
        if faults.is_full() {
            return;
        }
        let path = format!("{path}.obstacle.{}", target.name);
        if !scene
            .obstacles
            .iter()
            .any(|obstacle| obstacle.name == target.name)
        {
            let known = scene
                .obstacles
                .iter()
                .map(|obstacle| obstacle.name.as_str());
            let hint = names::hint(&target.name, known);
            faults.add(
                &path,
                format!("the scene has no obstacle `{}`{hint}", target.name),
            );
        }
        if let Some(translation) = target.translation {
            faults.finite(&format!("{path}.translation"), &translation);
            in_plane(faults, mesh, &format!("{path}.translation"), translation);
        }
        if let Some(rotation) = target.rotation {
            faults.finite(&format!("{path}.rotation"), &rotation);
            let about_z = rotation[0] == 0.0 && rotation[1] == 0.0;
            if mesh.cell_kind().dimension() == 2 && !about_z {
                faults.add(
                    format!("{path}.rotation"),
                    "must be about z in a plane scene",
                );
            }
        }
    }
    for target in &step.supports {
        if faults.is_full() {
            return;
        }
        let path = format!("{path}.support.{}", target.name);
        let Some(support) = scene.supports.iter().find(|s| s.name == target.name) else {
            let known = scene.supports.iter().map(|support| support.name.as_str());
            let hint = names::hint(&target.name, known);
            faults.add(
                &path,
                format!("the scene has no support `{}`{hint}", target.name),
            );
            continue;
        };
        for (axis, (value, held)) in target
            .displacement
            .iter()
            .zip(support.displacement)
            .enumerate()
        {
            let key = format!("{path}.displacement.{}", ["x", "y", "z"][axis]);
            match (value, held) {
                (Some(value), Some(_)) => {
                    faults.finite(&key, &[*value]);
                }
                (Some(_), None) => faults.add(key, "the support does not hold this component"),
                (None, _) => (),
            }
        }
    }
}
