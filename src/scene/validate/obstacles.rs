//! Obstacles: names, shapes, candidate faces.

use std::collections::BTreeSet;

use super::{Faults, Placed, ResolvedObstacle, ResolvedSupport, names};
use crate::mesh::{CellKind, Mesh};
use crate::obstacle::ObstacleError;
use crate::scene::{self, Scene, SceneError};

/// The obstacles with their shapes in units of `length`.
///
/// # Errors
/// [`SceneError::Invalid`] where a shape leaves the range of numbers in these units.
pub(crate) fn build(
    obstacles: Vec<Placed<'_, scene::Obstacle>>,
    length: f64,
) -> Result<Vec<ResolvedObstacle>, SceneError> {
    let mut faults = Faults::default();
    let mut built = Vec::new();
    for Placed { item, facets } in obstacles {
        match item.shape.build(length) {
            Ok(shape) => built.push(ResolvedObstacle {
                name: item.name.clone(),
                facets,
                shape,
                surface: item.surface,
                friction: item.friction,
                tresca: item.tresca,
                is_frictional: item.friction > 0.0 || item.tresca.is_some(),
            }),
            Err(error) => misshapen(item, &error, &mut faults),
        }
    }
    faults.result().map(|()| built)
}

fn misshapen(obstacle: &scene::Obstacle, error: &ObstacleError, faults: &mut Faults) {
    let path = format!("obstacle.{}.shape.{}", obstacle.name, error.parameter());
    faults.add(path, error.to_string());
}

/// The obstacles on the facets that may touch them.
pub(crate) fn resolve<'a>(
    scene: &'a Scene,
    mesh: &Mesh,
    faults: &mut Faults,
) -> Vec<Placed<'a, scene::Obstacle>> {
    let all = scene
        .obstacles
        .iter()
        .map(|obstacle| obstacle.name.as_str());
    names::check_unique(faults, "obstacle", all);
    scene
        .obstacles
        .iter()
        .map(|obstacle| {
            let path = format!("obstacle.{}", obstacle.name);
            check_shape(obstacle, mesh, faults);
            check_friction((obstacle.friction, obstacle.tresca), &path, faults);
            let on = format!("{path}.on");
            let facets = names::facets(mesh, &on, &obstacle.on, faults);
            names::refuse_inner_facets(mesh, &facets, on, faults);
            Placed {
                item: obstacle,
                facets,
            }
        })
        .collect()
}

/// Refuses coefficients and bounds without meaning, and both together.
/// Checks a coefficient of friction, or a bound in its place.
pub(super) fn check_friction(
    (friction, tresca): (f64, Option<f64>),
    path: &str,
    faults: &mut Faults,
) {
    faults.not_negative(&format!("{path}.friction"), friction);
    if let Some(bound) = tresca {
        faults.not_negative(&format!("{path}.tresca"), bound);
        if friction != 0.0 {
            faults.add(path, "give either friction or tresca, not both");
        }
    }
}

/// Refuses parameters without meaning and shapes that leave the plane of a flat body.
fn check_shape(obstacle: &scene::Obstacle, mesh: &Mesh, faults: &mut Faults) {
    let is_flat = mesh.cell_kind() == CellKind::Triangle;
    let built = obstacle.shape.build(1.0);
    let checked = built.and_then(|built| {
        if is_flat {
            built.lies_in_plane()
        } else {
            Ok(())
        }
    });
    if let Err(error) = checked {
        misshapen(obstacle, &error, faults);
    }
}

/// A face whose components are all held cannot move to meet an obstacle, and has no
/// normal component left to hold.
pub(crate) fn refuse_held_faces(
    mesh: &Mesh,
    supports: &[ResolvedSupport],
    obstacles: &[Placed<'_, scene::Obstacle>],
    faults: &mut Faults,
) {
    let dimension = mesh.cell_kind().dimension();
    let mut held: Vec<BTreeSet<&[u32]>> = vec![BTreeSet::new(); dimension];
    let keys_of = |support: &ResolvedSupport| {
        let keys = support.facets.iter().map(|&facet| key(mesh, facet));
        (support.displacement, keys.collect::<Vec<_>>())
    };
    let sorted: Vec<_> = supports.iter().map(keys_of).collect();
    for (displacement, keys) in &sorted {
        for (component, set) in held.iter_mut().enumerate() {
            if displacement[component].is_some() {
                set.extend(keys.iter().map(Vec::as_slice));
            }
        }
    }
    let stuck = |facets: &[u32]| -> Option<u32> {
        let is_stuck = |&&facet: &&u32| {
            let key = key(mesh, facet);
            held.iter().all(|set| set.contains(key.as_slice()))
        };
        facets.iter().find(is_stuck).copied()
    };
    for Placed { item, facets } in obstacles {
        if let Some(facet) = stuck(facets) {
            let message = format!(
                "facet {facet} may touch the obstacle, but supports hold all its components"
            );
            faults.add(format!("obstacle.{}.on", item.name), message);
        }
    }
    for support in supports.iter().filter(|support| support.normal.is_some()) {
        if let Some(facet) = stuck(&support.facets) {
            let message =
                format!("facet {facet} has a normal to hold, but supports hold all its components");
            faults.add(format!("support.{}.normal", support.name), message);
        }
    }
}

fn key(mesh: &Mesh, facet: u32) -> Vec<u32> {
    let mut vertices = mesh.facet(facet as usize).to_vec();
    vertices.sort_unstable();
    vertices
}
