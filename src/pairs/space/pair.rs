//! Two surfaces in space where they are: pieces of all faces, and what each adds to the gaps.
//!
//! Faces run in parallel; results come in their order. Shapes: of each face the six functions of its
//! corners and edges. Cost, in one thread: some 50 us a face to find its pieces, 0.2 us a point for
//! values.

use super::choice::{Candidate, Piece, Reach, pieces};
use super::depth::Depth;
use super::fold::SpaceFold;
use super::normals::{Normal, normals};
use super::outline::{Partner, straight, wedges};
use super::patch::{At, NODES, Patch, PlaceOf, bernstein};
use super::point::{Point, VECTORS};
use super::rays::Rayed;
use super::skin::Skin;
use crate::element::quadrature::{Rule, Simplex, rule};
use crate::geometry::vector3::{add, cross, dot, norm, scale, sub};
use crate::pairs::choice::{ASLANT, Role, WIDE};
use crate::pairs::pair::REACH;
use crate::pairs::tree::{Bounds, BoxTree};
use crate::parallel;

/// Degree of the rule on the triangles of a piece.
const DEGREE: u32 = 8;
/// Fewer faces are not worth a second thread.
const FEW: usize = 4;

/// Two surfaces in space that may touch.
#[derive(Clone, Debug)]
pub struct Pair {
    /// The surface that carries the multipliers.
    pub carrier: Skin,
    /// The other one.
    pub other: Skin,
    /// Who may meet whom, of surfaces of one body.
    pub fold: Option<SpaceFold>,
}

/// The pieces of a face.
#[derive(Clone, Debug)]
pub struct Meeting {
    /// Number of the face of the first surface.
    pub face: usize,
    /// Its pieces.
    pub pieces: Vec<Piece>,
}

/// Two surfaces where they are.
pub struct Placed<'a> {
    pub(super) pair: &'a Pair,
    /// Faces of the carrier.
    pub(super) own: Vec<Rayed>,
    /// Its faces without normals.
    pub(super) patches: Vec<Patch>,
    /// Its normals.
    pub(super) normals: Vec<Normal>,
    /// Faces of the other surface.
    pub(super) others: Vec<Patch>,
    rule: Rule,
    /// Faces that have pieces, ascending.
    pub meetings: Vec<Meeting>,
    /// How far partners are looked for.
    pub reach: f64,
}

/// Sums over the pieces of a face.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Totals {
    /// G of its functions.
    pub(super) gaps: [f64; NODES],
    /// int psi_j over what has a partner, by deformed area.
    pub(super) covered: [f64; NODES],
    /// The deepest penetration at a point of the rule.
    pub(super) deepest: f64,
}

/// Gradients of the six gaps of a face on one of its pieces, by the vectors.
pub(super) type Gradients = [[[f64; 3]; VECTORS]; NODES];

impl Pair {
    /// Finds who meets whom where nodes are at `place`.
    pub fn placed<'a>(&'a self, place: &PlaceOf<'_>) -> Placed<'a> {
        let patches = self.carrier.patches(place);
        let others = self.other.patches(place);
        let (normals, own) = self.carrier.rayed(&patches);
        let extents = [&patches, &others].map(|all| {
            let points = all.iter().flat_map(|patch| patch.hull());
            Bounds::of(points).diagonal()
        });
        let reach = REACH * extents[0].min(extents[1]);
        let candidates = self.candidates(&others);
        let boxes = candidates.iter().map(|own| bounds(&own.partner));
        let tree = BoxTree::new(boxes.collect());
        let found = parallel::map(own.len(), FEW, &|face| {
            let swept = Swept::of(&own[face], WIDE * reach);
            let near = tree.meeting_where(&|bounds| swept.meets(bounds));
            let near = near.iter();
            let near = near.filter_map(|&k| self.seen((face, &own[face]), candidates[k as usize]));
            let inside = match &self.fold {
                Some(fold) => fold.inside((face, &patches[face]), place, reach),
                None => Depth::even(reach),
            };
            let reach = Reach {
                open: reach,
                inside,
            };
            pieces(&own[face], &near.collect::<Vec<_>>(), reach)
        });
        let meetings = found.into_iter().enumerate();
        let meetings = meetings.filter(|(_, pieces)| !pieces.is_empty());
        Placed {
            pair: self,
            rule: rule(Simplex::Triangle, DEGREE),
            meetings: meetings
                .map(|(face, pieces)| Meeting { face, pieces })
                .collect(),
            own,
            patches,
            normals,
            others,
            reach,
        }
    }

    /// The faces of the other surface with what they go on by.
    pub(super) fn candidates(&self, others: &[Patch]) -> Vec<Candidate> {
        let skin = &self.other;
        let faces = self.other.faces.iter().zip(others).enumerate();
        let candidate =
            |(number, (face, &patch)): (usize, (&super::skin::SkinFace, &Patch))| Candidate {
                number,
                partner: Partner {
                    patch,
                    rims: face.rims,
                    beyond: [0, 1, 2].map(|corner| {
                        let far = skin.beyond[face.normals[corner] as usize];
                        far.map_or([0.0; 3], |far| sub(far.place(others), patch.nodes[corner]))
                    }),
                },
                normals: face.normals,
                role: Role::Apart,
                is_wall: false,
            };
        faces.map(candidate).collect()
    }

    /// A face of the other surface as a face of the carrier sees it; nothing where it does not.
    fn seen(&self, (face, own): (usize, &Rayed), candidate: Candidate) -> Option<Candidate> {
        let Some(fold) = &self.fold else {
            return Some(candidate);
        };
        let role = fold.role([&self.carrier, &self.other], [face, candidate.number])?;
        // What goes on beyond a corner stands out of the body: rays along the other side of the corner, and of
        // what touches that, would meet it.
        let is_square = || is_met_squarely(own, &candidate.partner);
        let partner = if role == Role::Meets && is_square() {
            fold.outside(candidate.number, candidate.partner)
        } else {
            candidate.partner.closed()
        };
        Some(Candidate {
            role,
            is_wall: fold.is_wall(face, &self.other.faces[candidate.number]),
            partner,
            ..candidate
        })
    }
}

impl Skin {
    /// Its normals where its faces are `patches`, and the faces with them.
    pub(super) fn rayed(&self, patches: &[Patch]) -> (Vec<Normal>, Vec<Rayed>) {
        let normals = normals(self, patches);
        let faces = self.faces.iter().zip(patches);
        let own = faces.map(|(face, &patch)| Rayed {
            patch,
            normals: face.normals.map(|k| normals[k as usize].unit),
        });
        let own = own.collect();
        (normals, own)
    }

    /// Its faces where nodes are at `place`.
    pub(super) fn patches(&self, place: &PlaceOf<'_>) -> Vec<Patch> {
        let faces = self.faces.iter();
        faces
            .map(|face| Patch {
                nodes: face.nodes.map(place),
            })
            .collect()
    }
}

impl Placed<'_> {
    /// Runs over the points of a piece with their weights.
    pub(super) fn each_point(
        &self,
        (face, piece): (usize, &Piece),
        see: &mut dyn FnMut(&Point, f64),
    ) {
        let (own, other) = (&self.own[face], &self.others[piece.other]);
        self.each_place(piece, &mut |at, weight| {
            if let Some(point) = Point::new(own, at, other) {
                see(&point, weight);
            }
        });
    }

    /// Runs over the places of the rule on a piece.
    fn each_place(&self, piece: &Piece, see: &mut dyn FnMut(At, f64)) {
        for wedge in wedges(&piece.polygon) {
            for (&l, weight) in self.rule.points.iter().zip(&self.rule.weights) {
                let (at, size) = wedge.place(l);
                see(at, 0.5 * size * weight);
            }
        }
    }

    /// Sums over the pieces of each meeting.
    pub(super) fn totals(&self) -> Vec<Totals> {
        parallel::map(self.meetings.len(), FEW, &|k| {
            let meeting = &self.meetings[k];
            let mut sums = Totals::default();
            for piece in &meeting.pieces {
                self.each_point((meeting.face, piece), &mut |point, weight| {
                    let values = bernstein(point.at);
                    let parts = [weight * point.swept(), weight * point.area()];
                    for (k, value) in values.into_iter().enumerate() {
                        sums.gaps[k] += parts[0] * value;
                        sums.covered[k] += parts[1] * value;
                    }
                    let depth = -point.met.gap * point.ray_length();
                    sums.deepest = sums.deepest.max(depth);
                });
            }
            sums
        })
    }

    /// Gradients of each piece of each meeting.
    pub(super) fn gradients(&self) -> Vec<Vec<Gradients>> {
        parallel::map(self.meetings.len(), FEW, &|k| {
            let meeting = &self.meetings[k];
            let pieces = meeting.pieces.iter();
            pieces
                .map(|piece| self.gradient((meeting.face, piece)))
                .collect()
        })
    }

    pub(super) fn gradient(&self, (face, piece): (usize, &Piece)) -> Gradients {
        let mut sums = [[[0.0; 3]; VECTORS]; NODES];
        let other = &self.others[piece.other];
        self.each_point((face, piece), &mut |point, weight| {
            let own = point.gradient(other);
            for (sum, value) in sums.iter_mut().zip(bernstein(point.at)) {
                for (sum, own) in sum.iter_mut().zip(own) {
                    *sum = add(*sum, scale(weight * value, own));
                }
            }
        });
        sums
    }

    /// Of linear bodies the gaps of each meeting, and their gradients on each of its pieces.
    pub(super) fn at_rest(&self) -> Vec<([f64; NODES], Vec<Gradients>)> {
        parallel::map(self.meetings.len(), FEW, &|k| {
            let meeting = &self.meetings[k];
            let mut gaps = [0.0; NODES];
            let of_piece = |piece| self.gradient_at_rest((meeting.face, piece), &mut gaps);
            let gradients = meeting.pieces.iter().map(of_piece).collect();
            (gaps, gradients)
        })
    }

    /// Adds a piece to the gaps of its face.
    fn gradient_at_rest(&self, piece: (usize, &Piece), gaps: &mut [f64; NODES]) -> Gradients {
        let mut sums = [[[0.0; 3]; VECTORS]; NODES];
        let other = &self.others[piece.1.other];
        self.each_point(piece, &mut |point, weight| {
            let (gap, own) = point.at_rest(other);
            for ((gaps, sum), value) in gaps.iter_mut().zip(&mut sums).zip(bernstein(point.at)) {
                *gaps += weight * value * gap;
                for (sum, own) in sum.iter_mut().zip(own) {
                    *sum = add(*sum, scale(weight * value, own));
                }
            }
        });
        sums
    }

    /// int psi_j over all of each face, by deformed area.
    pub(super) fn whole(&self) -> Vec<[f64; NODES]> {
        let all = Piece {
            other: 0,
            polygon: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(straight).into(),
        };
        parallel::map(self.own.len(), FEW, &|face| {
            let mut sums = [0.0; NODES];
            self.each_place(&all, &mut |at, weight| {
                let size = weight * norm(self.own[face].patch.area_vector(at));
                for (sum, value) in sums.iter_mut().zip(bernstein(at)) {
                    *sum += size * value;
                }
            });
            sums
        })
    }
}

/// Whether the mean ray of a face meets a partner by a cosine of at least `ASLANT`.
fn is_met_squarely(face: &Rayed, partner: &Partner) -> bool {
    let centre = [1.0 / 3.0; 2];
    let [ray, other] = [face.normal(centre), partner.patch.area_vector(centre)];
    dot(ray, other) <= -ASLANT * norm(ray) * norm(other)
}

/// Bounds of a face, and of what it goes on by.
fn bounds(partner: &Partner) -> Bounds {
    let corners = partner.patch.nodes.iter().zip(partner.beyond);
    let beyond = corners.map(|(corner, beyond)| add(*corner, beyond));
    Bounds::of(partner.patch.hull().into_iter().chain(beyond))
}

/// What the rays of a face reach: bounds, and a cylinder about the mean ray: a surface that is
/// turned against the axes has a part of itself in the bounds of long rays, whatever its mesh.
struct Swept {
    bounds: Bounds,
    /// The middle of the face.
    from: [f64; 3],
    /// Unit vector along the mean ray.
    along: [f64; 3],
    radius: f64,
}

impl Swept {
    /// Of the rays up to `reach`: between directions each is a sum of all with factors that add up to at
    /// most the reciprocal of the least cosine with their mean.
    fn of(face: &Rayed, reach: f64) -> Self {
        let centre = [1.0 / 3.0; 2];
        let (from, mean) = (face.patch.point(centre), face.normal(centre));
        let along = scale(norm(mean).recip(), mean);
        let cosines = face.normals.iter().map(|n| dot(*n, along));
        let far = reach / cosines.fold(1.0, f64::min).max(0.1);
        let mut ends = Vec::with_capacity(36);
        for x in face.patch.hull() {
            for normal in face.normals {
                for way in [far, -far] {
                    ends.push(add(x, scale(way, normal)));
                }
            }
        }
        let beside = |x: &[f64; 3]| norm(cross(along, sub(*x, from)));
        Self {
            radius: ends.iter().map(beside).fold(0.0, f64::max),
            bounds: Bounds::of(ends),
            from,
            along,
        }
    }

    fn meets(&self, bounds: &Bounds) -> bool {
        let beside = norm(cross(self.along, sub(bounds.centre(), self.from)));
        bounds.meets(&self.bounds) && beside <= self.radius + 0.5 * bounds.diagonal()
    }
}
