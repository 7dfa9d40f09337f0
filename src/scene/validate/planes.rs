//! Surfaces that a support holds along their normal, parted into planes across an axis, where
//! the normal is a component, and the rest:
//!
//! ```text
//! n . u = value   becomes   u_axis = outward value,   outward = n_axis = 1 or -1
//! ```
//!
//! Nodes of several planes are held along each of their axes. A support that a step of the scene
//! rotates keeps multipliers, for its planes leave their axes. Cost: one visit a facet.

use super::{HeldPlane, ObliquePlane};
use crate::assembly::load::facet_measure;
use crate::contact::patches::{outward, smooth_patches};
use crate::geometry::vector3::{add, dot, norm, normalised, scale, sub};
use crate::mesh::Mesh;
use crate::scene::Step;

/// Component of a unit normal that counts as none: chosen, between rounding (1e-15) and an
/// inclination that a mesh means; no scene measures it.
const ACROSS: f64 = 1e-9;
/// Distance of unit normals of one plane: coordinates of a mesh file have some nine digits.
const ACROSS_OBLIQUE: f64 = 1e-6;
/// Distance of planes over the extent of the mesh below which they are one; chosen alike.
const SAME_PLANE: f64 = 1e-9;

/// The planes across an axis among the smooth patches of `facets`, and the other patches.
pub(super) fn parted(
    mesh: &Mesh,
    (name, facets): (&str, &[u32]),
    steps: &[Step],
) -> (Vec<HeldPlane>, Vec<Vec<u32>>) {
    let patches = smooth_patches(mesh, facets);
    if steps.iter().any(|step| rotates(step, name)) {
        return (Vec::new(), patches);
    }
    let mut planes: Vec<HeldPlane> = Vec::new();
    let mut others = Vec::new();
    for patch in patches {
        let found = plane(mesh, &patch).filter(|new| {
            let width = SAME_PLANE * mesh.extent();
            // Which of two sides at one place a node belongs to its place does not tell.
            !planes.iter().any(|old| {
                let is_opposite = old.axis == new.axis && old.outward * new.outward < 0.0;
                is_opposite && (old.coordinate - new.coordinate).abs() <= width
            })
        });
        match found {
            Some(plane) => planes.push(plane),
            None => others.push(patch),
        }
    }
    (planes, others)
}

/// The planes among `patches`, and the other ones.
pub(super) fn oblique(mesh: &Mesh, patches: Vec<Vec<u32>>) -> (Vec<ObliquePlane>, Vec<Vec<u32>>) {
    let mut planes = Vec::new();
    let mut others = Vec::new();
    for patch in patches {
        match oblique_plane(mesh, &patch) {
            Some(normal) => planes.push(ObliquePlane {
                facets: patch,
                normal,
            }),
            None => others.push(patch),
        }
    }
    (planes, others)
}

/// The normal of a patch, where that is a plane and its edges are lines in it.
fn oblique_plane(mesh: &Mesh, patch: &[u32]) -> Option<[f64; 3]> {
    let measured = |facet: &u32| facet_measure(mesh, &outward(mesh, *facet), 1.0);
    let weighted = patch.iter().map(|facet| {
        let (area, normal) = measured(facet);
        scale(area, normal)
    });
    let normal = normalised(weighted.fold([0.0; 3], add))?;
    let is_flat = |facet: &u32| norm(sub(measured(facet).1, normal)) <= ACROSS_OBLIQUE;
    let is_in_plane = |facet: &u32| {
        let corners = mesh.facet(*facet as usize);
        let pairs = corners.iter().enumerate();
        let mut pairs = pairs.flat_map(|(k, &a)| corners[k + 1..].iter().map(move |&b| (a, b)));
        pairs.all(|(a, b)| {
            let offset = mesh.offset_between(a, b).unwrap_or_default();
            dot(offset, normal).abs() <= SAME_PLANE * mesh.extent()
        })
    };
    patch
        .iter()
        .all(|facet| is_flat(facet) && is_in_plane(facet))
        .then_some(normal)
}

/// Whether a step turns the support of that name.
pub(crate) fn rotates(step: &Step, name: &str) -> bool {
    let mut targets = step.supports.iter().filter(|target| target.name == name);
    targets.any(|target| {
        let rotation = target.rotation.unwrap_or_default();
        rotation.iter().any(|&angle| angle != 0.0)
    })
}

/// The plane of a patch, where it is one across an axis.
fn plane(mesh: &Mesh, patch: &[u32]) -> Option<HeldPlane> {
    let normal = |facet: &u32| facet_measure(mesh, &outward(mesh, *facet), 1.0).1;
    let first = normal(patch.first()?);
    let axis = (0..3).find(|&axis| is_along(first, axis))?;
    let is_plane = patch.iter().all(|facet| {
        let own = normal(facet);
        is_along(own, axis) && own[axis] * first[axis] > 0.0
    });
    let corner = mesh.facet(*patch.first()? as usize).first()?;
    is_plane.then(|| HeldPlane {
        facets: patch.to_vec(),
        axis,
        outward: first[axis].signum(),
        coordinate: mesh.coordinates()[*corner as usize][axis],
    })
}

fn is_along(normal: [f64; 3], axis: usize) -> bool {
    let mut others = (0..3).filter(|&other| other != axis);
    others.all(|other| normal[other].abs() <= ACROSS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{GroupKind, samples};

    fn facets(mesh: &Mesh, names: &[&str]) -> Vec<u32> {
        let groups = names.iter().map(|name| {
            let group = mesh.group(name, GroupKind::Facets).expect("a side");
            group.members.clone()
        });
        groups.flatten().collect()
    }

    #[test]
    fn the_sides_of_a_cube_are_planes_across_their_axes() {
        let mesh = samples::cube(2);
        let all = facets(&mesh, &["x0", "x1", "z0"]);
        let (planes, others) = parted(&mesh, ("box", &all), &[]);
        assert!(others.is_empty());
        let mut found: Vec<(usize, i32)> = (planes.iter())
            .map(|plane| (plane.axis, plane.outward as i32))
            .collect();
        found.sort_unstable();
        assert_eq!(found, [(0, -1), (0, 1), (2, -1)]);
    }

    #[test]
    fn a_support_that_a_step_rotates_keeps_its_patches() {
        let mesh = samples::cube(1);
        let step = Step {
            supports: vec![crate::scene::SupportTarget {
                name: "box".to_owned(),
                rotation: Some([0.0, 0.0, 0.1]),
                ..Default::default()
            }],
            ..Step::default()
        };
        let side = facets(&mesh, &["x0"]);
        let (planes, others) = parted(&mesh, ("box", &side), &[step]);
        assert!(planes.is_empty() && others.len() == 1);
    }
}
