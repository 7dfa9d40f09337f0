//! Obstacles: names, shapes, candidate faces.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::{Faults, names};
use crate::mesh::{CellKind, GroupKind, Mesh};
use crate::obstacle::{Cylinder, HalfSpace, Obstacle, ObstacleError, Sphere};
use crate::scene::{Scene, Shape};

/// The obstacle of `shape` with lengths divided by `length`.
pub(crate) fn shape(shape: &Shape, length: f64) -> Result<Arc<dyn Obstacle>, ObstacleError> {
    let scaled = |v: &[f64; 3]| v.map(|x| x / length);
    Ok(match shape {
        Shape::HalfSpace { point, normal } => Arc::new(HalfSpace::new(scaled(point), *normal)?),
        Shape::Sphere { centre, radius } => Arc::new(Sphere::new(scaled(centre), radius / length)?),
        Shape::Cylinder {
            point,
            axis,
            radius,
        } => Arc::new(Cylinder::new(scaled(point), *axis, radius / length)?),
    })
}

/// Facets of each obstacle.
pub(crate) fn resolve(scene: &Scene, mesh: &Mesh, faults: &mut Faults) -> Vec<Vec<u32>> {
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
            if let Err(error) = shape(&obstacle.shape, 1.0) {
                faults.add(
                    format!("{path}.shape.{}", error.parameter()),
                    error.to_string(),
                );
            }
            check_plane(&obstacle.shape, mesh, &path, faults);
            let on = format!("{path}.on");
            let facets = names::members(mesh, GroupKind::Facets, &on, &obstacle.on, faults);
            names::refuse_inner_facets(mesh, &facets, on, faults);
            facets
        })
        .collect()
}

fn check_plane(shape: &Shape, mesh: &Mesh, path: &str, faults: &mut Faults) {
    if mesh.cell_kind() != CellKind::Triangle {
        return;
    }
    let (key, wrong) = match shape {
        Shape::HalfSpace { normal, .. } => ("normal", normal[2] != 0.0),
        Shape::Sphere { centre, .. } => ("centre", centre[2] != 0.0),
        Shape::Cylinder { axis, .. } => ("axis", axis[0] != 0.0 || axis[1] != 0.0),
    };
    if wrong {
        let message = "does not lie in the plane z = 0 of the body (a cylinder's axis must be z)";
        faults.add(format!("{path}.shape.{key}"), message);
    }
}

/// A face whose components are all held cannot move to meet an obstacle.
pub(crate) fn refuse_held_faces(
    scene: &Scene,
    mesh: &Mesh,
    support_facets: &[Vec<u32>],
    obstacle_facets: &[Vec<u32>],
    faults: &mut Faults,
) {
    let dimension = mesh.cell_kind().dimension();
    let mut held: Vec<BTreeSet<&[u32]>> = vec![BTreeSet::new(); dimension];
    let mut sorted = Vec::new();
    for facets in support_facets {
        sorted.push(facets.iter().map(|&f| key(mesh, f)).collect::<Vec<_>>());
    }
    for (support, keys) in scene.supports.iter().zip(&sorted) {
        for (component, set) in held.iter_mut().enumerate() {
            if support.displacement[component].is_some() {
                set.extend(keys.iter().map(Vec::as_slice));
            }
        }
    }
    for (obstacle, facets) in scene.obstacles.iter().zip(obstacle_facets) {
        let stuck = |&&facet: &&u32| {
            let key = key(mesh, facet);
            held.iter().all(|set| set.contains(key.as_slice()))
        };
        if let Some(facet) = facets.iter().find(stuck) {
            let message = format!(
                "facet {facet} may touch the obstacle, but supports hold all its components"
            );
            faults.add(format!("obstacle.{}.on", obstacle.name), message);
        }
    }
}

fn key(mesh: &Mesh, facet: u32) -> Vec<u32> {
    let mut vertices = mesh.facet(facet as usize).to_vec();
    vertices.sort_unstable();
    vertices
}
