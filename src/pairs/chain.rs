//! A surface in the plane as faces in a row: who is beside whom, and where it ends.
//!
//! Faces run with the body on their left. Two that follow each other share the normal of their common
//! vertex where they turn by at most 30 degrees, by the tangents of their curved edges at rest; a
//! sharper corner is an end of both. The surface that carries no multipliers goes straight on beyond
//! its ends by a share of their faces: without that, the gap jumps where a ray passes an end, and
//! Newton's method is linear or cycles there. At a wall along which its end is held a surface ends by
//! the wall: a normal a little off it leaves out a part of the gap whose force at 1e2 shear moduli is
//! that of the body. Cost: one map of the vertices.

use std::collections::BTreeMap;

use super::piece::{Beside, dot, slope};
use crate::contact::patches::SMOOTH;
use crate::contact::patches::outward;
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Share of a face by which a surface goes on beyond its end, without unit; chosen.
pub(super) const BEYOND: f64 = 0.3;

/// Where nodes are: of a vertex its place, of an edge that of its middle less the mean of its ends.
pub type PlaceOf<'a> = dyn Fn(u32) -> [f64; 2] + Sync + 'a;

/// A face of a surface in the plane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChainFace {
    /// Displacement nodes: ends a and b with the body to the left of the way from a to b, then the
    /// edge.
    pub nodes: [u32; 3],
    /// Outer vertex and edge of the face before a, and of that after b, which share its normals.
    pub beside: [Option<[u32; 2]>; 2],
    /// Normals of the walls along which a and b are held, in the direction of the face.
    pub walls: [Option<[i8; 2]>; 2],
    /// Whether the mesh has its vertices the other way round.
    pub is_turned: bool,
}

/// Faces in the order in which they were given.
#[derive(Clone, Debug)]
pub struct Chain {
    /// All of them.
    pub faces: Vec<ChainFace>,
}

impl Chain {
    /// Of some `facets` of the boundary of a mesh in the plane.
    pub fn new(mesh: &Mesh, space: &TaylorHood, facets: &[u32]) -> Self {
        let bare = |&facet: &u32| {
            let corners = outward(mesh, facet);
            let [a, b] = [corners[0], corners[1]];
            let edge = space.edge_between(a, b);
            ChainFace {
                nodes: [a, b, edge.map_or(a, |edge| (space.vertices + edge) as u32)],
                beside: [None, None],
                walls: [None, None],
                is_turned: mesh.facet(facet as usize)[0] != a,
            }
        };
        let mut faces: Vec<ChainFace> = facets.iter().map(bare).collect();
        let starts = by_vertex(&faces, 0);
        let ends = by_vertex(&faces, 1);
        let all = faces.clone();
        for face in &mut faces {
            let [a, b, _] = face.nodes;
            let before = ends.get(&a).copied().flatten().map(|k| all[k].nodes);
            let after = starts.get(&b).copied().flatten().map(|k| all[k].nodes);
            let is_smooth = |pair: [[u32; 3]; 2]| turn(mesh, space, pair) >= SMOOTH;
            let before = before.filter(|&other| is_smooth([other, face.nodes]));
            let after = after.filter(|&other| is_smooth([face.nodes, other]));
            face.beside = [
                before.map(|[outer, _, edge]| [outer, edge]),
                after.map(|[_, outer, edge]| [outer, edge]),
            ];
        }
        Self { faces }
    }

    /// The same between walls: ends without a neighbour of which just one component is held, about along
    /// the face, by `is_held` displacement unknowns.
    pub fn between_walls(mut self, mesh: &Mesh, is_held: &dyn Fn(u32) -> bool) -> Self {
        for face in &mut self.faces {
            for end in [0, 1] {
                let vertex = face.nodes[end];
                let held = [0, 1].map(|axis| is_held(2 * vertex + axis));
                let axis = match held {
                    [true, false] => 0,
                    [false, true] => 1,
                    _ => continue,
                };
                let along = face.way(mesh);
                let cosine = along[axis] / dot(along, along).sqrt();
                if face.beside[end].is_none() && cosine.abs() >= SMOOTH {
                    let mut wall = [0, 0];
                    wall[axis] = if cosine > 0.0 { 1 } else { -1 };
                    face.walls[end] = Some(wall);
                }
            }
        }
        self
    }
}

impl ChainFace {
    /// What gives the normals at its ends.
    pub(super) fn sides(&self) -> [Beside; 2] {
        [0, 1].map(|end| match (self.walls[end], self.beside[end]) {
            (Some(wall), _) => Beside::Wall(wall),
            (None, Some(_)) => Beside::Face,
            (None, None) => Beside::Nothing,
        })
    }

    /// The way from its first to its second end at rest.
    pub(super) fn way(&self, mesh: &Mesh) -> [f64; 2] {
        let [a, b] = [0, 1].map(|end: usize| mesh.coordinates()[self.nodes[end] as usize]);
        [b[0] - a[0], b[1] - a[1]]
    }

    /// Whether `other` shares a normal with it.
    pub(super) fn is_beside(&self, other: &Self) -> bool {
        let edge = other.nodes[2];
        self.beside.iter().flatten().any(|beside| beside[1] == edge)
    }

    /// Part of its line that rays may meet.
    pub(super) fn range(&self) -> [f64; 2] {
        let [before, after] = self.beside.map(|beside| beside.is_some());
        [
            if before { 0.0 } else { -BEYOND },
            if after { 1.0 } else { 1.0 + BEYOND },
        ]
    }
}

/// The face at each vertex by its `end`; none where several are.
pub(super) fn by_vertex(faces: &[ChainFace], end: usize) -> BTreeMap<u32, Option<usize>> {
    let mut at = BTreeMap::new();
    for (index, face) in faces.iter().enumerate() {
        let known = at.entry(face.nodes[end]);
        known.and_modify(|one| *one = None).or_insert(Some(index));
    }
    at
}

/// Cosine between the tangents of two faces where the first one ends.
pub(super) fn turn(mesh: &Mesh, space: &TaylorHood, [first, second]: [[u32; 3]; 2]) -> f64 {
    let plane = |[x, y, _]: [f64; 3]| [x, y];
    let nodes = |[a, b, edge]: [u32; 3]| {
        let corner = |vertex: u32| plane(mesh.coordinates()[vertex as usize]);
        let middle = (edge as usize).checked_sub(space.vertices);
        let middle = middle.map_or([0.0; 2], |edge| plane(mesh.offset_of(edge)));
        [corner(a), corner(b), middle]
    };
    let [first, second] = [slope(nodes(first), 1.0), slope(nodes(second), 0.0)];
    dot(first, second) / (dot(first, first) * dot(second, second)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{GroupKind, samples};

    fn chain(names: &[&str]) -> (Mesh, Chain) {
        let mesh = samples::rectangle(3, 2);
        let groups = names.iter().map(|name| {
            let group = mesh.group(name, GroupKind::Facets).expect("a side");
            group.members.clone()
        });
        let facets: Vec<u32> = groups.flatten().collect();
        let chain = Chain::new(&mesh, &TaylorHood::new(&mesh), &facets);
        (mesh, chain)
    }

    #[test]
    fn faces_run_with_the_body_on_their_left() {
        let (mesh, top) = chain(&["y1"]);
        let x = |vertex: u32| mesh.coordinates()[vertex as usize][0];
        assert_eq!(top.faces.len(), 3);
        assert!(
            top.faces
                .iter()
                .all(|face| x(face.nodes[0]) > x(face.nodes[1]))
        );
    }

    #[test]
    fn neighbours_share_normals_but_not_around_a_corner() {
        let (_, both) = chain(&["y1", "x1"]);
        let open = both.faces.iter().flat_map(|face| face.beside);
        assert_eq!(open.filter(Option::is_none).count(), 4);
        let is_whole = |[from, to]: [f64; 2]| from.abs() + (to - 1.0).abs() < 1e-14;
        let whole = both.faces.iter().filter(|face| is_whole(face.range()));
        assert_eq!(whole.count(), 1);
    }
}
