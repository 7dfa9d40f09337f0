//! Smooth patches of a surface: facets joined across edges (in the plane: vertices)
//! where their normals differ little. Nodes between two patches carry multipliers of
//! both. Cost: one sort of the edges.
//!
//! Neighbours share a side; a patch is all that can be reached over sides at which the
//! angle between the outward normals is at most 30 degrees. Patches come in the order of
//! their first facets, so that the numbering of multipliers does not depend on hashing.

use std::collections::BTreeMap;

use crate::assembly::load::facet_measure;
use crate::geometry::vector3::dot;
use crate::mesh::Mesh;

/// Least cosine between normals of neighbours on one smooth surface: 30 degrees, without unit; chosen.
pub const SMOOTH: f64 = 0.866;

/// `facet` of the boundary with its vertices in the order that turns its normal out of
/// the body.
pub fn outward(mesh: &Mesh, facet: u32) -> Vec<u32> {
    let mut vertices = mesh.facet(facet as usize).to_vec();
    let (cell, opposite) = mesh.facet_cell(facet as usize);
    let inner = mesh.corners(cell)[opposite];
    let (_, normal) = facet_measure(mesh, &vertices, 1.0);
    let at = mesh.coordinates()[vertices[0] as usize];
    let inwards: f64 = (0..3).map(|i| normal[i] * (inner[i] - at[i])).sum();
    if inwards > 0.0 {
        vertices.swap(0, 1);
    }
    vertices
}

/// The patches of `facets`, each in the order given, by their first facets.
pub fn smooth_patches(mesh: &Mesh, facets: &[u32]) -> Vec<Vec<u32>> {
    let normals: Vec<[f64; 3]> = facets
        .iter()
        .map(|&facet| facet_measure(mesh, &outward(mesh, facet), 1.0).1)
        .collect();
    let mut label: Vec<usize> = (0..facets.len()).collect();
    for sides in neighbours(mesh, facets).values() {
        for pair in sides.windows(2) {
            if dot(normals[pair[0]], normals[pair[1]]) >= SMOOTH {
                join(&mut label, pair[0], pair[1]);
            }
        }
    }
    let mut patches: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
    for (index, &facet) in facets.iter().enumerate() {
        let root = root(&mut label, index);
        patches.entry(root).or_default().push(facet);
    }
    patches.into_values().collect()
}

/// Positions of the facets at each of their sides.
pub(super) fn neighbours(mesh: &Mesh, facets: &[u32]) -> BTreeMap<Vec<u32>, Vec<usize>> {
    let mut at: BTreeMap<Vec<u32>, Vec<usize>> = BTreeMap::new();
    for (index, &facet) in facets.iter().enumerate() {
        let vertices = mesh.facet(facet as usize);
        for left_out in 0..vertices.len() {
            let mut side = vertices.to_vec();
            side.remove(left_out);
            side.sort_unstable();
            at.entry(side).or_default().push(index);
        }
    }
    at
}

/// The representative of the set that holds `index`; halves the path on its way, so
/// that later look-ups are short.
pub(super) fn root(label: &mut [usize], mut index: usize) -> usize {
    while label[index] != index {
        label[index] = label[label[index]];
        index = label[index];
    }
    index
}

/// The smaller root stays, so that patches come by their first facets.
pub(super) fn join(label: &mut [usize], a: usize, b: usize) {
    let (a, b) = (root(label, a), root(label, b));
    label[a.max(b)] = a.min(b);
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
    fn the_sides_of_a_cube_are_patches_of_their_own() {
        let mesh = samples::cube(2);
        let patches = smooth_patches(&mesh, &facets(&mesh, &["z1", "x0", "y1"]));
        assert_eq!(patches.iter().map(Vec::len).collect::<Vec<_>>(), [8, 8, 8]);
        let whole = smooth_patches(&mesh, &facets(&mesh, &["z1"]));
        assert_eq!(whole, [facets(&mesh, &["z1"])]);
    }

    #[test]
    fn normals_point_out_of_the_body() {
        for (mesh, name, expected) in [
            (samples::cube(2), "x0", [-1.0, 0.0, 0.0]),
            (samples::cube(2), "z1", [0.0, 0.0, 1.0]),
            (samples::rectangle(2, 3), "y0", [0.0, -1.0, 0.0]),
        ] {
            for facet in facets(&mesh, &[name]) {
                let (_, normal) = facet_measure(&mesh, &outward(&mesh, facet), 1.0);
                assert!(dot(normal, expected) > 1.0 - 1e-12, "{name} {normal:?}");
            }
        }
    }
}
