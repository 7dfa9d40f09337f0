//! Edges of a body in space that close: those at which a face of the carrier and one of the other surface
//! make a corner that points into the body.
//!
//! Such an edge moves with both faces, so that no pressure at its nodes is held by a motion. Cost: one sort
//! of the edges.

use std::collections::{BTreeMap, BTreeSet};

use super::patch::EDGES;
use super::skin::Skin;
use super::still::{Still, are_across};
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Displacement nodes of the creases between two surfaces, vertices and edges.
pub fn creases(ground: (&Mesh, &TaylorHood), sides: [&[u32]; 2]) -> BTreeSet<u32> {
    let (mesh, space) = ground;
    let [carrier, other] = sides.map(|facets| Skin::new(mesh, space, facets));
    creases_between(ground, [&carrier, &other])
}

/// The same of two surfaces.
pub(super) fn creases_between(
    ground: (&Mesh, &TaylorHood),
    [carrier, other]: [&Skin; 2],
) -> BTreeSet<u32> {
    let mut at: BTreeMap<u32, [Vec<[usize; 2]>; 2]> = BTreeMap::new();
    for (side, skin) in [carrier, other].into_iter().enumerate() {
        for (number, face) in skin.faces.iter().enumerate() {
            for (edge, &node) in face.nodes[3..].iter().enumerate() {
                at.entry(node).or_default()[side].push([number, edge]);
            }
        }
    }
    let mut found = BTreeSet::new();
    for (node, [own, others]) in at {
        let faces = |skin: &Skin, all: &[[usize; 2]]| -> Vec<Still> {
            let faces = all.iter().map(|&[number, _]| &skin.faces[number]);
            faces.map(|face| Still::new(ground, face)).collect()
        };
        let [first, second] = [faces(carrier, &own), faces(other, &others)];
        let closes = |a: &Still| second.iter().any(|b| are_across([*a, *b]));
        let crease = own.first().filter(|_| first.iter().any(closes));
        if let Some(&[number, edge]) = crease {
            let ends = EDGES[edge].map(|end| carrier.faces[number].nodes[end]);
            found.extend(ends.into_iter().chain([node]));
        }
    }
    found
}
