//! Which face of a surface in space that meets itself carries: one order of all its faces, of which those
//! before carry against those behind.
//!
//! The surface is cut into patches: faces that follow each other smoothly and whose normals are within
//! `PATCH` of the first one's, by face numbers, so that no two faces of a patch face each other at rest.
//! Patches that rays from their faces find opposite to each other get opposite sides, those with more area
//! in sight first, then patches that go on smoothly the same side,
//!
//! ```text
//! side_p = 1 - side_q   p faces q,        side_p = side_q   p goes on as q
//! ```
//!
//! as far as these do not contradict each other. Of opposite patches one side carries all along: a patch
//! that carried against one and were met by the next would have functions of both at their border. Of two
//! sides the one with the smallest patch carries, of equal ones that with more faces, as in the plane
//! ([`crate::pairs::order`]). Within a patch faces are ordered along its longest extent, as along a line,
//! so that a patch that folds later meets itself. Cost: one ray a face and a sort.

use std::cmp::Reverse;
use std::collections::{BTreeMap, VecDeque};

use super::rays::Ray;
use super::shell::Shell;
use super::skin::Skin;
use super::still::Still;
use crate::geometry::vector3::dot;
use crate::mesh::Mesh;
use crate::pairs::choice::GRAZING;
use crate::pairs::fold::OFF;
use crate::pairs::order::ALIKE;

/// Least cosine between the normals of a patch and that of its first face: 45 degrees, so that no two are
/// turned by more than a right angle; without unit.
const PATCH: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Place of each face in the order `[faces]`, of faces that are `still` at rest.
pub(super) fn ranks(mesh: &Mesh, shell: &Shell, (skin, still): (&Skin, &[Still])) -> Vec<usize> {
    let beside = beside(skin);
    let patches = Patches::new(still, &beside);
    let sides = sides(&patches, (skin, still), (shell, &beside));
    let along = patches.along(still);
    let key = |patch: usize| patches.key(patch, ALIKE * mesh.extent());
    let keys: Vec<_> = (0..patches.count).map(key).collect();
    let carries = carrying(&sides, &keys);
    let mut order: Vec<usize> = (0..still.len()).collect();
    order.sort_by(|&a, &b| {
        let [p, q] = [a, b].map(|face| patches.of_face[face]);
        carries[p]
            .cmp(&carries[q])
            .then(keys[p].cmp(&keys[q]))
            .then(along[a].total_cmp(&along[b]))
            .then(a.cmp(&b))
    });
    let mut ranks = vec![0; order.len()];
    for (rank, face) in order.into_iter().enumerate() {
        ranks[face] = rank;
    }
    ranks
}

/// Faces that go on smoothly beside each face `[faces]`.
fn beside(skin: &Skin) -> Vec<Vec<usize>> {
    let mut edges: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (number, face) in skin.faces.iter().enumerate() {
        for (edge, _) in face.rims.iter().enumerate().filter(|(_, is_rim)| !**is_rim) {
            edges.entry(face.nodes[3 + edge]).or_default().push(number);
        }
    }
    let mut beside = vec![Vec::new(); skin.faces.len()];
    for faces in edges.into_values() {
        if let [a, b] = faces[..] {
            beside[a].push(b);
            beside[b].push(a);
        }
    }
    beside
}

/// The patches of a surface.
struct Patches {
    of_face: Vec<usize>,
    count: usize,
    /// Area and number of faces of each.
    sizes: Vec<(f64, usize)>,
}

/// Area in steps, more faces first, number.
type Key = (u64, Reverse<usize>, usize);

impl Patches {
    fn new(still: &[Still], beside: &[Vec<usize>]) -> Self {
        let mut of_face = vec![usize::MAX; still.len()];
        let mut sizes = Vec::new();
        for first in 0..still.len() {
            if of_face[first] != usize::MAX {
                continue;
            }
            let patch = sizes.len();
            let (mut area, mut faces) = (0.0, 0);
            of_face[first] = patch;
            let mut open = VecDeque::from([first]);
            while let Some(face) = open.pop_front() {
                area += 0.5 * still[face].size * still[face].size;
                faces += 1;
                for &next in &beside[face] {
                    let is_alike = dot(still[first].normal, still[next].normal) >= PATCH;
                    if of_face[next] == usize::MAX && is_alike {
                        of_face[next] = patch;
                        open.push_back(next);
                    }
                }
            }
            sizes.push((area, faces));
        }
        Self {
            of_face,
            count: sizes.len(),
            sizes,
        }
    }

    fn key(&self, patch: usize, step: f64) -> Key {
        let (area, faces) = self.sizes[patch];
        ((area.sqrt() / step).round() as u64, Reverse(faces), patch)
    }

    /// Where each face is along the longest extent of its patch `[faces]`.
    fn along(&self, still: &[Still]) -> Vec<f64> {
        let nothing = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let mut extents = vec![nothing; self.count];
        for (face, own) in self.of_face.iter().zip(still) {
            let [low, high] = &mut extents[*face];
            for (i, x) in own.middle.into_iter().enumerate() {
                low[i] = low[i].min(x);
                high[i] = high[i].max(x);
            }
        }
        let axes = extents.iter().map(|[low, high]| {
            let longer = |best: usize, i: usize| high[i] - low[i] > high[best] - low[best];
            (1..3).fold(0, |best, i| if longer(best, i) { i } else { best })
        });
        let axes: Vec<usize> = axes.collect();
        let faces = self.of_face.iter().zip(still);
        faces.map(|(&patch, own)| own.middle[axes[patch]]).collect()
    }
}

/// Sides of patches, as far as they are known to each other: a forest with the side to the parent.
struct Sides {
    parent: Vec<usize>,
    flipped: Vec<bool>,
    /// Whether a patch has another one opposite to it.
    faces: Vec<bool>,
}

impl Sides {
    /// The first of a set, and whether `patch` is on the other side.
    fn root(&self, mut patch: usize) -> (usize, bool) {
        let mut flipped = false;
        while self.parent[patch] != patch {
            flipped ^= self.flipped[patch];
            patch = self.parent[patch];
        }
        (patch, flipped)
    }

    /// Puts two patches on opposite sides or on the same, where nothing says otherwise.
    fn join(&mut self, [p, q]: [usize; 2], relation: Relation) {
        let [(a, own), (b, other)] = [p, q].map(|one| self.root(one));
        if a != b {
            let (low, high) = (a.min(b), a.max(b));
            self.parent[high] = low;
            self.flipped[high] = own ^ other ^ (relation == Relation::Opposite);
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Relation {
    Opposite,
    Same,
}

/// Areas over which pairs of patches are related, ascending by patches.
type Seen = BTreeMap<[usize; 2], f64>;

/// The sides of patches by what faces see and by what goes on smoothly.
fn sides(
    patches: &Patches,
    (skin, still): (&Skin, &[Still]),
    (shell, beside): (&Shell, &[Vec<usize>]),
) -> Sides {
    let opposite = opposite(patches, (skin, still), shell);
    let mut smooth = Seen::new();
    for (face, own) in beside.iter().enumerate() {
        let pairs = own
            .iter()
            .map(|&next| [face, next].map(|k| patches.of_face[k]));
        for [p, q] in pairs.filter(|[p, q]| p < q) {
            *smooth.entry([p, q]).or_default() += still[face].size;
        }
    }
    let mut sides = Sides {
        parent: (0..patches.count).collect(),
        flipped: vec![false; patches.count],
        faces: vec![false; patches.count],
    };
    for &patch in opposite.keys().flatten() {
        sides.faces[patch] = true;
    }
    for (seen, relation) in [(opposite, Relation::Opposite), (smooth, Relation::Same)] {
        let mut seen: Vec<([usize; 2], f64)> = seen.into_iter().collect();
        seen.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        seen.into_iter()
            .for_each(|(pair, _)| sides.join(pair, relation));
    }
    sides
}

/// Pairs of patches that rays of their faces find opposite to each other.
fn opposite(patches: &Patches, (skin, still): (&Skin, &[Still]), shell: &Shell) -> Seen {
    let corners = |nodes: &[u32]| {
        let mut own = [nodes[0], nodes[1], nodes[2]];
        own.sort_unstable();
        own
    };
    let faces = skin.faces.iter().enumerate();
    let numbers: BTreeMap<[u32; 3], usize> = faces
        .map(|(number, face)| (corners(&face.nodes), number))
        .collect();
    let mut seen = Seen::new();
    for (face, own) in still.iter().enumerate() {
        let ray = Ray {
            from: own.middle,
            along: own.normal,
        };
        let met = shell.first(ray, OFF * own.size);
        let met = met.and_then(|met| numbers.get(&corners(&shell.nodes[met.face])));
        let Some(&other) = met.filter(|&&other| dot(own.normal, still[other].normal) <= -GRAZING)
        else {
            continue;
        };
        let mut pair = [face, other].map(|k| patches.of_face[k]);
        pair.sort_unstable();
        *seen.entry(pair).or_default() += own.size * own.size;
    }
    seen
}

/// Place of each patch among carriers (0), what faces nothing (1) and what is met (2).
fn carrying(sides: &Sides, keys: &[Key]) -> Vec<u8> {
    let mut order: Vec<usize> = (0..keys.len()).collect();
    order.sort_by_key(|&patch| keys[patch]);
    // Of each set the side that carries: that of the first patch that faces another one.
    let mut carrier: BTreeMap<usize, bool> = BTreeMap::new();
    for patch in order.into_iter().filter(|&patch| sides.faces[patch]) {
        let (root, flipped) = sides.root(patch);
        carrier.entry(root).or_insert(flipped);
    }
    let place = |patch: usize| {
        let (root, flipped) = sides.root(patch);
        match carrier.get(&root) {
            None => 1,
            Some(own) => 2 * u8::from(flipped != *own),
        }
    };
    (0..keys.len()).map(place).collect()
}
