//! Surfaces of one body in space that meet each other, and a surface that meets itself: who may meet
//! whom.
//!
//! ```text
//! rank_i       place of face i in the order in which faces carry
//! i meets j    rank_i < rank_j, and the ray from i meets nothing else on its way, nor its neighbours
//! depth        at l at most t(l) / 2,   t = |x(l) - y_back|;   none towards the wall behind i itself
//! ```
//!
//! As in the plane ([`crate::pairs::fold`]): of two parts that touch the one that comes first in one order
//! of all faces carries ([`super::order`]); y_back is the point behind x across the body at rest, carried
//! along. Faces with a common vertex meet where each lies in front of the other and they turn by more than
//! smooth ones do: across a crease that points into the body. Beside an edge of the body rays that look
//! inwards leave it through the other side of that edge, which they meet as what has come in from outside;
//! that wall is known at rest, with all that shares a vertex with it. Assumes one mesh; lengths are those of
//! the caller. Cost: thirteen rays a face through the boundary, once.

use super::creases::creases_between;
use super::depth::Depth;
use super::order::ranks;
use super::outline::Partner;
use super::patch::{At, NODES, Patch, PlaceOf};
use super::shell::Shell;
use super::skin::{Skin, SkinFace};
use super::still::{Still, are_across, at_rest};
use crate::geometry::vector3::{norm, sub};
use crate::mesh::Mesh;
use crate::pairs::choice::Role;
use crate::pairs::fold::{INWARDS, Meets, OFF};
use crate::parallel;
use crate::space::TaylorHood;

/// Where the wall behind a face is measured: halfway between its middle and its corners.
const MEASURED_AT: [At; 3] = [
    [1.0 / 6.0, 1.0 / 6.0],
    [2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0],
];
/// Fewer faces are not worth a second thread.
const FEW: usize = 16;
/// Where rays look for the wall behind a face, beside those: at its middle, beside its corners and its edges.
const WALLS_AT: [At; 7] = [
    [1.0 / 3.0, 1.0 / 3.0],
    [0.01, 0.01],
    [0.98, 0.01],
    [0.01, 0.98],
    [0.49, 0.02],
    [0.02, 0.49],
    [0.49, 0.49],
];
/// A point of the boundary: a facet by its nodes, and the place on it.
#[derive(Clone, Copy, Debug)]
struct Back {
    nodes: [u32; NODES],
    at: At,
}

/// Who may meet whom where both surfaces are of one body.
#[derive(Clone, Debug)]
pub struct SpaceFold {
    /// What is behind each face of the carrier `[faces]`, at `MEASURED_AT`.
    backs: Vec<[Option<Back>; 3]>,
    /// Vertices of the wall behind each face of the carrier `[faces]`, ascending.
    walls: Vec<Vec<u32>>,
    /// Place of each face of a surface that meets itself in their order `[faces]`; empty where it meets another.
    ranks: Vec<usize>,
    /// Faces of both at rest `[faces]`.
    still: [Vec<Still>; 2],
    /// Edges of the other surface that are creases `[faces]`: beyond these is the body.
    creases: Vec<[bool; 3]>,
}

impl SpaceFold {
    /// Of the two surfaces of a body at rest; none where they are of different ones.
    pub(super) fn new(
        ground: (&Mesh, &TaylorHood),
        [carrier, other]: [&Skin; 2],
        meets: Meets,
    ) -> Option<Self> {
        if meets == Meets::AnotherBody {
            return None;
        }
        let shell = Shell::new(ground);
        let inwards = creases_between(ground, [carrier, other]);
        let still = [carrier, other].map(|skin| -> Vec<Still> {
            let faces = skin.faces.iter();
            faces.map(|face| Still::new(ground, face)).collect()
        });
        let behind = |number: usize| {
            let patch = at_rest(ground, &carrier.faces[number]);
            (backs(&shell, &patch), wall(&shell, &patch))
        };
        let behind = parallel::map(carrier.faces.len(), FEW, &behind);
        let (backs, walls) = behind.into_iter().unzip();
        Some(Self {
            backs,
            walls,
            ranks: match meets {
                Meets::Itself => ranks(ground.0, &shell, (carrier, &still[0])),
                Meets::AnotherBody | Meets::ItsBody => Vec::new(),
            },
            still,
            creases: other
                .faces
                .iter()
                .map(|face| [3, 4, 5].map(|k: usize| inwards.contains(&face.nodes[k])))
                .collect(),
        })
    }

    /// A face of the other surface without what it would go on by into the body.
    pub(super) fn outside(&self, face: usize, partner: Partner) -> Partner {
        let mut rims = partner.rims;
        for (is_rim, is_crease) in rims.iter_mut().zip(self.creases[face]) {
            *is_rim &= !is_crease;
        }
        Partner { rims, ..partner }
    }

    /// How far rays of a face look inwards, at most `reach`.
    pub(super) fn inside(
        &self,
        (face, patch): (usize, &Patch),
        place: &PlaceOf<'_>,
        reach: f64,
    ) -> Depth {
        let walls = [0, 1, 2].map(|k: usize| {
            let back = self.backs[face][k].as_ref()?;
            let behind = Patch {
                nodes: back.nodes.map(place),
            };
            let apart = sub(patch.point(MEASURED_AT[k]), behind.point(back.at));
            Some(INWARDS * norm(apart))
        });
        let Some(least) = walls.into_iter().flatten().min_by(f64::total_cmp) else {
            return Depth::even(reach);
        };
        let walls = walls.map(|wall| wall.unwrap_or(least));
        let mean = walls.iter().sum::<f64>() / 3.0;
        // A plane through all three.
        let [a, b, c] = walls.map(|wall| (2.0 * wall - mean).max(0.0).min(reach));
        Depth::of_corners([a, b, c])
    }

    /// Whether the face `met` of the other surface is of the wall behind the face `own` of the carrier.
    pub(super) fn is_wall(&self, own: usize, met: &SkinFace) -> bool {
        let walls = &self.walls[own];
        let mut corners = met.nodes[..3].iter();
        corners.any(|node| walls.binary_search(node).is_ok())
    }

    /// What the face `other` of the other surface is to the face `own` of the carrier; nothing where
    /// neither may meet nor hide the other.
    pub(super) fn role(
        &self,
        [carrier, others]: [&Skin; 2],
        [own, other]: [usize; 2],
    ) -> Option<Role> {
        let [face, met] = [&carrier.faces[own], &others.faces[other]];
        let corners = &met.nodes[..3];
        let common = face.nodes[..3].iter().filter(|node| corners.contains(node));
        let is_beside = match common.count() {
            0 => false,
            3 => return None,
            _ => true,
        };
        let still = [self.still[0][own], self.still[1][other]];
        if is_beside && !are_across(still) {
            return None;
        }
        Some(Role::by_ranks(&self.ranks, [own, other]))
    }
}

/// What is behind a face at `MEASURED_AT`.
fn backs(shell: &Shell, patch: &Patch) -> [Option<Back>; 3] {
    MEASURED_AT.map(|at| {
        let met = shell.behind(patch, at, OFF)?;
        Some(Back {
            nodes: shell.nodes[met.face],
            at: met.hit.at,
        })
    })
}

/// Vertices of the wall behind a face, ascending.
fn wall(shell: &Shell, patch: &Patch) -> Vec<u32> {
    let places = WALLS_AT.into_iter().chain(MEASURED_AT);
    let met = places.filter_map(|at| shell.behind(patch, at, OFF));
    let corners = met.flat_map(|met| shell.nodes[met.face].into_iter().take(3));
    let mut corners: Vec<u32> = corners.collect();
    corners.sort_unstable();
    corners.dedup();
    corners
}
