//! Surfaces of one body that meet each other, and a surface that meets itself: who may meet whom.
//!
//! ```text
//! rank_i       place of face i in the order in which faces carry
//! i meets j    rank_i < rank_j, and the ray from i meets nothing else on its way, nor its neighbours
//! depth        at s at most t(s) / 2,   t = |x(s) - y_back|
//! ```
//!
//! Of two parts that touch the one that comes first in one order of all faces carries (`order`): no face
//! carries and is met in the same contact, however often the surface folds. y_back is the point behind x
//! across the body at rest, carried along: a ray inwards meets what has come in, never the own back side,
//! however thin a wall is pressed. Faces with a common vertex at a smooth place or a convex corner never meet.
//! Assumes one body in the plane or a section; lengths are those of the caller. Cost: one ray a face
//! through the boundary, once.

use std::collections::{BTreeMap, BTreeSet};

use super::chain::{Chain, ChainFace, PlaceOf};
use super::choice::Role;
use super::order::ranks;
use super::piece::{cross, dot, minus, point};
use super::tree::{Bounds, BoxTree};
use crate::contact::patches::SMOOTH;
use crate::contact::patches::outward;
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Where the wall behind a face is measured.
const MEASURED_AT: [f64; 2] = [0.25, 0.75];
/// Share of a wall to which rays look inwards.
pub(super) const INWARDS: f64 = 0.5;
/// Share of a face from which on a ray inwards has left its own face.
pub(super) const OFF: f64 = 1e-6;

/// Whom a surface meets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Meets {
    /// A surface of another body.
    #[default]
    AnotherBody,
    /// Another surface of its own body.
    ItsBody,
    /// Itself.
    Itself,
}

/// A point of the boundary: a facet by its nodes, and the place on it.
#[derive(Clone, Copy, Debug)]
struct Back {
    nodes: [u32; 3],
    r: f64,
}

/// Who may meet whom where both surfaces are of one body.
#[derive(Clone, Debug)]
pub struct Fold {
    /// What is behind each face of the carrier `[faces]`, at `MEASURED_AT`.
    backs: Vec<[Option<Back>; 2]>,
    /// Place of each face of a surface that meets itself in their order `[faces]`; empty where it meets another.
    ranks: Vec<usize>,
    /// Ways of the faces of both at rest `[faces]`.
    ways: [Vec<[f64; 2]>; 2],
}

impl Fold {
    /// Of the two surfaces of a body at rest; none where they are of different ones.
    pub fn new(
        (mesh, space): (&Mesh, &TaylorHood),
        [carrier, other]: [&Chain; 2],
        meets: Meets,
    ) -> Option<Self> {
        if meets == Meets::AnotherBody {
            return None;
        }
        let body = Boundary::new(mesh, space);
        let back = |face: &ChainFace| MEASURED_AT.map(|s| body.behind(face, s));
        let ways = |chain: &Chain| chain.faces.iter().map(|face| face.way(mesh)).collect();
        Some(Self {
            backs: carrier.faces.iter().map(back).collect(),
            ranks: match meets {
                Meets::Itself => ranks(mesh, space, carrier),
                Meets::AnotherBody | Meets::ItsBody => Vec::new(),
            },
            ways: [ways(carrier), ways(other)],
        })
    }

    /// How far rays of a face look inwards at its ends, at most `reach`.
    pub(super) fn inside(
        &self,
        (face, nodes): (usize, [[f64; 2]; 3]),
        place: &PlaceOf<'_>,
        reach: f64,
    ) -> [f64; 2] {
        let wall = |end: usize| {
            let back = self.backs[face][end].as_ref()?;
            let apart = minus(
                point(nodes, MEASURED_AT[end]),
                point(back.nodes.map(place), back.r),
            );
            Some(INWARDS * dot(apart, apart).sqrt())
        };
        let [first, last] = match [wall(0), wall(1)] {
            [None, None] => [reach; 2],
            [one, other] => [one.or(other), other.or(one)].map(Option::unwrap_or_default),
        };
        // A straight line through both.
        let change = (last - first) / (MEASURED_AT[1] - MEASURED_AT[0]);
        let ends = [0.0, 1.0].map(|s| first + (s - MEASURED_AT[0]) * change);
        ends.map(|depth| depth.clamp(0.0, reach))
    }

    /// What the face `other` of the other surface is to the face `own` of the carrier; nothing where
    /// neither may meet nor hide the other.
    pub(super) fn role(
        &self,
        [carrier, others]: [&Chain; 2],
        [own, other]: [usize; 2],
    ) -> Option<Role> {
        let [face, met] = [&carrier.faces[own], &others.faces[other]];
        if face.nodes == met.nodes {
            return None;
        }
        let ways = [self.ways[0][own], self.ways[1][other]];
        if let Some([before, after]) = followed(face, met, ways)
            && (face.is_beside(met) || cross(before, after) >= 0.0)
        {
            return None;
        }
        Some(Role::by_ranks(&self.ranks, [own, other]))
    }
}

/// Vertices where a face of the carrier and one of the other surface, side by side, make a corner that
/// points into the body: a crease that closes there lets the vertex move with both, so that no pressure
/// at it is held by a motion.
pub fn creases(mesh: &Mesh, [carrier, other]: [&[u32]; 2]) -> BTreeSet<u32> {
    let at = |vertex: u32| {
        let [x, y, _] = mesh.coordinates()[vertex as usize];
        [x, y]
    };
    let ways = |facets: &[u32], end: usize| {
        let mut by_vertex: BTreeMap<u32, Vec<[f64; 2]>> = BTreeMap::new();
        for &facet in facets {
            let corners = outward(mesh, facet);
            let way = minus(at(corners[1]), at(corners[0]));
            by_vertex.entry(corners[end]).or_default().push(way);
        }
        by_vertex
    };
    let mut found = BTreeSet::new();
    for [first, last] in [[carrier, other], [other, carrier]] {
        let after = ways(last, 0);
        for (vertex, before) in ways(first, 1) {
            let after = after.get(&vertex).into_iter().flatten();
            let is_crease =
                |after: &[f64; 2]| before.iter().any(|before| turns_in(*before, *after));
            if after.into_iter().any(is_crease) {
                found.insert(vertex);
            }
        }
    }
    found
}

/// Whether a surface turns into the body, by more than smooth ones do.
fn turns_in(before: [f64; 2], after: [f64; 2]) -> bool {
    let sizes = dot(before, before) * dot(after, after);
    cross(before, after) < 0.0 && dot(before, after) < SMOOTH * sizes.sqrt()
}

/// Ways of two faces with a common vertex, along the surface; none where they have none.
fn followed(
    face: &ChainFace,
    met: &ChainFace,
    [own, other]: [[f64; 2]; 2],
) -> Option<[[f64; 2]; 2]> {
    if face.nodes[1] == met.nodes[0] {
        Some([own, other])
    } else if met.nodes[1] == face.nodes[0] {
        Some([other, own])
    } else {
        None
    }
}

/// The boundary of a body in the plane at rest.
struct Boundary<'a> {
    mesh: &'a Mesh,
    facets: Vec<[u32; 3]>,
    tree: BoxTree,
}

impl<'a> Boundary<'a> {
    fn new(mesh: &'a Mesh, space: &TaylorHood) -> Self {
        let facet = |[a, b]: [u32; 2]| {
            let edge = space.edge_between(a, b);
            [a, b, edge.map_or(a, |edge| (space.vertices + edge) as u32)]
        };
        let all = mesh.boundary_facets().iter();
        let facets: Vec<[u32; 3]> = all
            .map(|one| facet([one.vertices[0], one.vertices[1]]))
            .collect();
        let corners = |&[a, b, _]: &[u32; 3]| [a, b].map(|v| mesh.coordinates()[v as usize]);
        Self {
            tree: BoxTree::new(facets.iter().map(|one| Bounds::of(corners(one))).collect()),
            mesh,
            facets,
        }
    }

    fn at(&self, vertex: u32) -> [f64; 2] {
        let [x, y, _] = self.mesh.coordinates()[vertex as usize];
        [x, y]
    }

    /// The first point of the boundary that is met on the way inwards from `s` of a face.
    fn behind(&self, face: &ChainFace, s: f64) -> Option<Back> {
        let [a, b] = [self.at(face.nodes[0]), self.at(face.nodes[1])];
        let way = minus(b, a);
        let from = [0, 1].map(|i| a[i] + s * way[i]);
        let size = dot(way, way).sqrt();
        // To the left of the way, where the body is.
        let inwards = [-way[1] / size, way[0] / size];
        let far = 2.0 * self.mesh.extent();
        let end = [0, 1].map(|i| from[i] + far * inwards[i]);
        let region = Bounds::of([from, end].map(|[x, y]| [x, y, 0.0]));
        let near = self.tree.meeting(&region).into_iter();
        let hits = near.filter_map(|one| {
            let nodes = self.facets[one as usize];
            let [c, d] = [self.at(nodes[0]), self.at(nodes[1])];
            let along = minus(d, c);
            let across = cross(inwards, along);
            let apart = minus(c, from);
            let [t, r] = [cross(apart, along) / across, cross(apart, inwards) / across];
            let is_hit = t > OFF * size && (0.0..=1.0).contains(&r);
            is_hit.then_some((t, Back { nodes, r }))
        });
        let first = hits.min_by(|a, b| a.0.total_cmp(&b.0));
        first.map(|(_, back)| back)
    }
}
