//! A surface of triangles: which faces share the normal of a corner, where it ends, and along which
//! walls.
//!
//! Faces that meet at an edge at which they turn by at most 30 degrees, by their curved surfaces at
//! rest, share the normals of its ends; other edges are rims of both. At a wall along which a rim is
//! held its normals have no component across the wall, so that no part of the gap is left out there.
//! The surface that carries no multipliers goes on beyond its rims by a share of their faces. Cost: one
//! sort of the edges.

use std::collections::BTreeMap;

use super::patch::{At, EDGES, NODES, Patch};
use crate::contact::patches::SMOOTH;
use crate::contact::patches::outward;
use crate::geometry::vector3::{add, dot, norm, normalised, scale, sub};
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Places of the middles of the edges.
const MIDDLES: [At; 3] = [[0.5, 0.0], [0.0, 0.5], [0.5, 0.5]];

/// A face of a surface in space.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkinFace {
    /// Displacement nodes: corners with the normal out of the body, then edges (0,1), (0,2), (1,2).
    pub nodes: [u32; NODES],
    /// Numbers of the normals at its corners.
    pub normals: [u32; 3],
    /// Which edges are rims.
    pub rims: [bool; 3],
    /// Whether the mesh has its first two corners the other way round.
    pub is_turned: bool,
}

/// A normal and the corners that share it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fan {
    /// Faces, and which of their corners it is.
    pub corners: Vec<[u32; 2]>,
    /// Axes across walls, along which it has no component.
    pub walls: [bool; 3],
}

/// Where a surface goes on to from a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Far {
    /// A face that has the corner.
    pub face: u32,
    /// Shares of its three corners.
    pub shares: [f64; 3],
}

/// Faces in the order in which they were given.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// All of them.
    pub faces: Vec<SkinFace>,
    /// Normals.
    pub fans: Vec<Fan>,
    /// Where it goes on to beyond its rims, by the numbers of normals; none inside.
    pub beyond: Vec<Option<Far>>,
}

impl Skin {
    /// Of some `facets` of the boundary of a mesh in space.
    pub fn new(mesh: &Mesh, space: &TaylorHood, facets: &[u32]) -> Self {
        let bare = |&facet: &u32| {
            let corners = outward(mesh, facet);
            let mut nodes = [corners[0]; NODES];
            for (node, own) in nodes.iter_mut().zip(space.facet_nodes(&corners)) {
                *node = own;
            }
            SkinFace {
                nodes,
                normals: [0; 3],
                rims: [true; 3],
                is_turned: mesh.facet(facet as usize)[0] != corners[0],
            }
        };
        let mut skin = Self {
            faces: facets.iter().map(bare).collect(),
            ..Self::default()
        };
        let at_rest = |node: u32| match (node as usize).checked_sub(space.vertices) {
            None => mesh.coordinates()[node as usize],
            Some(edge) => mesh.offset_of(edge),
        };
        skin.join(&at_rest);
        skin
    }

    /// Finds rims and shared normals of a surface whose nodes are there at rest.
    pub(super) fn join(&mut self, at_rest: &dyn Fn(u32) -> [f64; 3]) {
        let mut edges: BTreeMap<u32, Vec<[usize; 2]>> = BTreeMap::new();
        for (number, face) in self.faces.iter().enumerate() {
            for edge in 0..3 {
                let at = edges.entry(face.nodes[3 + edge]).or_default();
                at.push([number, edge]);
            }
        }
        let mut label: Vec<usize> = (0..3 * self.faces.len()).collect();
        for sides in edges.values() {
            let &[first, second] = &sides[..] else {
                continue;
            };
            let normals = [first, second].map(|[face, edge]| {
                let patch = Patch {
                    nodes: self.faces[face].nodes.map(at_rest),
                };
                patch.area_vector(MIDDLES[edge])
            });
            let cosine = dot(normals[0], normals[1]);
            if cosine < SMOOTH * norm(normals[0]) * norm(normals[1]) {
                continue;
            }
            for [face, edge] in [first, second] {
                self.faces[face].rims[edge] = false;
            }
            self.share(first, second, &mut label);
        }
        self.number(&mut label);
        let patches = self.faces.iter().map(|face| Patch {
            nodes: face.nodes.map(at_rest),
        });
        self.beyond = self.found_beyond(&patches.collect::<Vec<_>>());
    }

    /// Joins the corners at the ends of a common edge.
    fn share(&self, first: [usize; 2], second: [usize; 2], label: &mut [usize]) {
        for a in EDGES[first[1]] {
            for b in EDGES[second[1]] {
                if self.faces[first[0]].nodes[a] == self.faces[second[0]].nodes[b] {
                    let [a, b] = [3 * first[0] + a, 3 * second[0] + b].map(|k| root(label, k));
                    label[a.max(b)] = a.min(b);
                }
            }
        }
    }

    /// Numbers the normals by their first corners.
    fn number(&mut self, label: &mut [usize]) {
        let mut numbers = BTreeMap::new();
        for slot in 0..label.len() {
            let next = numbers.len() as u32;
            let number = *numbers.entry(root(label, slot)).or_insert(next);
            if number == next {
                self.fans.push(Fan::default());
            }
            let [face, corner] = [slot / 3, slot % 3];
            self.faces[face].normals[corner] = number;
            self.fans[number as usize]
                .corners
                .push([face as u32, corner as u32]);
        }
    }

    /// The same between walls: rims of whose nodes one component is held, about across the rim and in
    /// the surface, by `is_held` displacement unknowns.
    pub fn between_walls(mut self, mesh: &Mesh, is_held: &dyn Fn(u32) -> bool) -> Self {
        for face in &self.faces {
            for (edge, [a, b]) in EDGES.into_iter().enumerate() {
                let ends = [a, b];
                let nodes = [face.nodes[a], face.nodes[b], face.nodes[3 + edge]];
                let held = |axis: u32| nodes.iter().all(|node| is_held(3 * node + axis));
                let held = [0, 1, 2].map(held);
                if !face.rims[edge] || held == [true; 3] {
                    continue;
                }
                let corners = [0, 1, 2].map(|k: usize| mesh.coordinates()[face.nodes[k] as usize]);
                let Some(across) = normalised(across(&corners, ends)) else {
                    continue;
                };
                for axis in (0..3).filter(|&axis| held[axis] && across[axis].abs() >= SMOOTH) {
                    for end in ends {
                        self.fans[face.normals[end] as usize].walls[axis] = true;
                    }
                }
            }
        }
        self
    }
}

/// From an edge of a flat triangle straight outwards, as long as the triangle is high there.
pub(super) fn across(corners: &[[f64; 3]; 3], [i, j]: [usize; 2]) -> [f64; 3] {
    let opposite = corners[3 - i - j];
    let along = sub(corners[j], corners[i]);
    let inwards = sub(opposite, corners[i]);
    let share = dot(inwards, along) / dot(along, along);
    sub(scale(share, along), inwards)
}

/// The representative of the set that holds `index`.
fn root(label: &mut [usize], mut index: usize) -> usize {
    while label[index] != index {
        label[index] = label[label[index]];
        index = label[index];
    }
    index
}

/// The tangents along the edges of a face at one of its corners.
pub(super) fn corner_tangents(patch: &Patch, corner: usize) -> [[f64; 3]; 2] {
    [1, 2].map(|k| {
        let end = (corner + k) % 3;
        let along = sub(patch.nodes[end], patch.nodes[corner]);
        add(along, scale(4.0, patch.nodes[edge_between(corner, end)]))
    })
}

/// The node of the edge between two corners.
pub(super) fn edge_between(a: usize, b: usize) -> usize {
    2 + a + b
}
