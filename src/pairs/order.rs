//! Which face of a surface that meets itself carries: one order of all its faces, of which those before
//! carry against those behind.
//!
//! The order is that along the surface, which begins at its end, a closed one at its sharpest corner,
//! where no contact goes through. What ends at a corner that points outwards comes before all that, shorter
//! stretches first, of equal ones the finer: where two such corners stand side by side on a third part,
//! functions of both end with them and hold them, but a function of the third part sees only what both
//! do together. Three blocks in a closed box lose their stability at 0.8 shear moduli where the third one
//! carries, at 12 where the coarser side between the other two does, and not up to 100 otherwise. Order
//! within a stretch has no jump, so that no face carries against one and is met by its neighbour.
//! Cost: a sort of the faces.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use super::chain::{Chain, by_vertex, turn};
use super::piece::{cross, dot};
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Lengths that differ by less of the extent of the mesh are equal: in a mesh and its mirror image they
/// differ by rounding; without unit, chosen.
pub(super) const ALIKE: f64 = 1e-6;

/// Place of each face in the order `[faces]`.
pub(super) fn ranks(mesh: &Mesh, space: &TaylorHood, chain: &Chain) -> Vec<usize> {
    let mut stretches = stretches(mesh, space, chain);
    let corners = Corners::new(mesh, chain);
    stretches.sort_by_key(|stretch| {
        let key = corners.ends(stretch).then(|| corners.key(stretch));
        (key.is_none(), key)
    });
    let mut ranks = vec![0; chain.faces.len()];
    for (rank, face) in stretches.into_iter().flatten().enumerate() {
        ranks[face] = rank;
    }
    ranks
}

/// The corners of a surface.
struct Corners<'a> {
    mesh: &'a Mesh,
    chain: &'a Chain,
    /// The face at each vertex by its first and by its last end.
    at: [BTreeMap<u32, Option<usize>>; 2],
}

impl<'a> Corners<'a> {
    fn new(mesh: &'a Mesh, chain: &'a Chain) -> Self {
        Self {
            mesh,
            chain,
            at: [0, 1].map(|end| by_vertex(&chain.faces, end)),
        }
    }

    /// Whether a stretch ends at a corner that points outwards.
    fn ends(&self, stretch: &[usize]) -> bool {
        let at = |end: usize, face: usize| {
            let vertex = self.chain.faces[face].nodes[end];
            let other = self.at[1 - end].get(&vertex).copied().flatten();
            other.is_some_and(|other| {
                let way = |face: usize| self.chain.faces[face].way(self.mesh);
                let [before, after] = if end == 0 {
                    [other, face]
                } else {
                    [face, other]
                };
                let is_smooth = self.chain.faces[face].is_beside(&self.chain.faces[other]);
                !is_smooth && cross(way(before), way(after)) > 0.0
            })
        };
        let first = stretch.first().is_some_and(|&face| at(0, face));
        first || stretch.last().is_some_and(|&face| at(1, face))
    }

    /// What comes first of two stretches that do.
    fn key(&self, stretch: &[usize]) -> (u64, Reverse<usize>) {
        let ways = stretch
            .iter()
            .map(|&face| self.chain.faces[face].way(self.mesh));
        let length: f64 = ways.map(|way| dot(way, way).sqrt()).sum();
        let steps = (length / (ALIKE * self.mesh.extent())).round();
        (steps as u64, Reverse(stretch.len()))
    }
}

/// Faces between corners, one after the other along the surface: parts one after the other, each from
/// its end or its sharpest corner on.
fn stretches(mesh: &Mesh, space: &TaylorHood, chain: &Chain) -> Vec<Vec<usize>> {
    let faces = &chain.faces;
    let starts = by_vertex(faces, 0);
    let ends = by_vertex(faces, 1);
    let follower =
        |at: &BTreeMap<u32, Option<usize>>, vertex: u32| at.get(&vertex).copied().flatten();
    let after = |face: usize| follower(&starts, faces[face].nodes[1]);
    let before = |face: usize| follower(&ends, faces[face].nodes[0]);
    let cosine = |face: usize| {
        let pair = before(face).map(|one| [faces[one].nodes, faces[face].nodes]);
        pair.map_or(-1.0, |pair| turn(mesh, space, pair))
    };
    let mut first: Vec<usize> = (0..faces.len()).collect();
    // Ends come first, then corners by their sharpness.
    let key = |face: &usize| (before(*face).is_some(), cosine(*face));
    first.sort_by(|a, b| {
        let [a, b] = [key(a), key(b)];
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut seen = vec![false; faces.len()];
    let mut stretches: Vec<Vec<usize>> = Vec::new();
    for start in first {
        let mut at = Some(start);
        while let Some(face) = at.filter(|&face| !seen[face]) {
            seen[face] = true;
            match stretches.last_mut() {
                Some(own) if face != start && faces[face].beside[0].is_some() => own.push(face),
                _ => stretches.push(vec![face]),
            }
            at = after(face);
        }
    }
    stretches
}
