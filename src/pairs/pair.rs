//! Two surfaces that may touch, in the plane: gaps measured by volume, and their derivatives.
//!
//! ```text
//! G_j = sum over the pieces of the faces of the first surface of int psi_j a ds   (see piece)
//! ```
//!
//! The first surface carries the multipliers. Shapes: of each face the three functions of its ends and
//! its edge; derivatives by the places of the ten nodes of a piece. Faces run in parallel; results
//! come in their order. Cost, in one thread: 2 us a face to find partners; of a piece 0.3 us for values,
//! 30 us for first derivatives and 0.45 ms for second ones, which only faces under pressure need.

use std::f64::consts::TAU;

use super::chain::{Chain, ChainFace, PlaceOf};
use super::choice::{Partner, Reach, Role, WIDE, pieces};
use super::fold::Fold;
use super::number::{First, Number, Second};
use super::piece::{
    Face, INPUTS, NODES, NodePlaces, Piece, Section, Sweep, bernstein, dot, meeting, point, slope,
    to_the_right,
};
use super::tree::{Bounds, BoxTree};
use crate::element::quadrature::{Simplex, rule};
use crate::parallel;

/// Degree of the rule on a piece: volumes between two wavy rings then agree to 1e-13 in the plane and
/// 1e-12 about an axis.
const DEGREE: u32 = 9;
/// How far a partner is looked for, over the extent of the smaller surface.
pub(super) const REACH: f64 = 0.25;
/// Fewer faces are not worth a second thread.
const FEW: usize = 8;

/// Two surfaces that may touch.
#[derive(Clone, Debug)]
pub struct Pair {
    /// The surface that carries the multipliers.
    pub carrier: Chain,
    /// The other one.
    pub other: Chain,
    /// What the plane is a section of.
    pub section: Section,
    /// Who may meet whom, of surfaces of one body.
    pub fold: Option<Fold>,
}

/// A part of a face with its partner.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// Number of the face of the first surface.
    pub face: usize,
    /// Number of the face of the other surface.
    pub other: usize,
    /// The part.
    pub piece: Piece,
}

/// What a meeting adds to the gaps of its face.
#[derive(Clone, Copy, Debug)]
pub struct Part<T> {
    /// Number of the face.
    pub face: usize,
    /// Displacement nodes that it depends on.
    pub nodes: [u32; NODES],
    /// Gaps, areas.
    pub gaps: [T; 3],
}

/// Two surfaces where they are.
pub struct Placed<'a> {
    pair: &'a Pair,
    place: &'a PlaceOf<'a>,
    /// Places and weights on \[0, 1\].
    rule: Vec<[f64; 2]>,
    /// All meetings, by faces and along them.
    pub meetings: Vec<Meeting>,
    /// How far partners are looked for.
    pub reach: f64,
}

/// A point of the rule on a face that has a partner there.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// Place on the face.
    pub s: f64,
    /// Place on the partner.
    pub r: f64,
    /// Distance along the ray, negative inside.
    pub distance: f64,
    /// Weight times the deformed length.
    pub length: f64,
}

impl ChainFace {
    fn places(&self, place: &PlaceOf<'_>) -> [[f64; 2]; 3] {
        self.nodes.map(place)
    }
}

impl Pair {
    /// Finds who meets whom where nodes are at `place`.
    pub fn placed<'a>(&'a self, place: &'a PlaceOf<'a>) -> Placed<'a> {
        let faces = self.other.faces.iter();
        let partners: Vec<Partner> = faces
            .map(|face| Partner {
                nodes: face.places(place),
                range: face.range(),
                role: Role::Apart,
            })
            .collect();
        let boxes: Vec<Bounds> = partners.iter().map(bounds_of).collect();
        let own = self.carrier.faces.iter().map(|face| face.places(place));
        let own = own.flat_map(|[a, b, _]| [a, b]).map(in_space);
        let extents = [
            Bounds::of(own),
            boxes.iter().fold(Bounds::NONE, |all, one| all.with(one)),
        ];
        let least = extents.map(|one| one.diagonal());
        let reach = REACH * least[0].min(least[1]);
        let tree = BoxTree::new(boxes);
        let found = parallel::map(self.carrier.faces.len(), FEW, &|face| {
            self.meetings_of(face, place, (&tree, &partners), reach)
        });
        Placed {
            pair: self,
            place,
            rule: unit_rule(),
            meetings: found.concat(),
            reach,
        }
    }

    fn meetings_of(
        &self,
        face: usize,
        place: &PlaceOf<'_>,
        (tree, partners): (&BoxTree, &[Partner]),
        reach: f64,
    ) -> Vec<Meeting> {
        let own = &self.carrier.faces[face];
        let beside = own.sides();
        let at = Face::new(&places_of(own, None, place), beside);
        let near = tree.meeting(&swept(&at, WIDE * reach));
        let near = near.into_iter().map(|one| one as usize);
        let near = near.filter_map(|one| Some((one, self.seen(face, (one, partners[one]))?)));
        let (near, candidates): (Vec<usize>, Vec<Partner>) = near.unzip();
        let inside = match &self.fold {
            Some(fold) => fold.inside((face, at.nodes), place, reach),
            None => [reach; 2],
        };
        let reach = Reach {
            open: reach,
            inside,
        };
        let pieces = pieces(&at, beside, &candidates, reach).into_iter();
        let meeting = |(partner, piece): (usize, Piece)| Meeting {
            face,
            other: near[partner],
            piece,
        };
        pieces.map(meeting).collect()
    }

    /// A face of the other surface as a face of the carrier sees it; nothing where it does not.
    fn seen(&self, face: usize, (other, partner): (usize, Partner)) -> Option<Partner> {
        let Some(fold) = &self.fold else {
            return Some(partner);
        };
        let role = fold.role([&self.carrier, &self.other], [face, other])?;
        let range = match role {
            Role::Apart | Role::Meets => partner.range,
            Role::Hides => [0.0, 1.0],
        };
        Some(Partner {
            role,
            range,
            ..partner
        })
    }
}

impl Placed<'_> {
    /// What each meeting adds to the gaps, values alone.
    pub fn gaps(&self) -> Vec<Part<f64>> {
        self.parts(&|meeting| {
            let places = self.places(meeting);
            meeting.piece.gaps(&places, self.sweep())
        })
    }

    /// The same with first derivatives by the places of the nodes: x of the first, y of the first, x
    /// of the second and so on.
    pub fn first(&self) -> Vec<Part<First<INPUTS>>> {
        self.parts(&|meeting| {
            let places = inputs(&self.places(meeting), First::input);
            meeting.piece.gaps(&places, self.sweep())
        })
    }

    /// sum_j factor_j G_j of each meeting with its second derivatives, of those faces where a factor is
    /// not zero; `factors` `[faces]`.
    pub fn second(&self, factors: &[[f64; 3]]) -> Vec<([u32; NODES], Box<Second<INPUTS>>)> {
        let loaded = self.meetings.iter();
        let loaded: Vec<&Meeting> = loaded
            .filter(|meeting| factors[meeting.face].iter().any(|&factor| factor != 0.0))
            .collect();
        parallel::map(loaded.len(), 1, &|k| {
            let meeting = loaded[k];
            let places = inputs(&self.places(meeting), Second::input);
            let factors = factors[meeting.face];
            let sum = meeting.piece.weighted(&places, self.sweep(), factors);
            (self.nodes(meeting), Box::new(sum))
        })
    }

    /// int psi_j over the part of each face that has a partner, and over the whole face, by deformed
    /// length `[faces]`.
    pub fn covered(&self) -> Vec<[[f64; 3]; 2]> {
        let own = self.pair.carrier.faces.iter();
        let mut sums: Vec<[[f64; 3]; 2]> = own
            .map(|face| [[0.0; 3], self.integrals(face, [0.0, 1.0])])
            .collect();
        for meeting in &self.meetings {
            let own = self.counted_areas(meeting);
            let sum = &mut sums[meeting.face][0];
            sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        }
        sums
    }

    /// int psi_j over what counts of a meeting, by deformed length.
    pub(super) fn counted_areas(&self, meeting: &Meeting) -> [f64; 3] {
        let ends = meeting.piece.ends.map(|end| end.place());
        if !meeting.piece.fades() {
            return self.integrals(&self.pair.carrier.faces[meeting.face], ends);
        }
        let (face, other) = (self.face(meeting.face), self.other_places(meeting));
        let sites = meeting.piece.sites(&self.places(meeting), &self.rule);
        let mut sums = [0.0; 3];
        for site in sites {
            let area = site.weight * face.stretch(site.s, self.pair.section);
            let gap = face.gap(site.s, other, site.r);
            let values = meeting.piece.counted(&face, site.s, gap);
            sums.iter_mut()
                .zip(values)
                .for_each(|(sum, value)| *sum += area * value);
        }
        sums
    }

    /// int psi_j from one place of a face to another.
    fn integrals(&self, face: &ChainFace, [first, last]: [f64; 2]) -> [f64; 3] {
        let nodes = face.places(self.place);
        let mut sums = [0.0; 3];
        for [at, weight] in &self.rule {
            let s = first + at * (last - first);
            let along = slope(nodes, s);
            let length = weight * (last - first) * dot(along, along).sqrt();
            let length = match self.pair.section {
                Section::Plane => length,
                Section::AboutAxis => length * TAU * point(nodes, s)[0],
            };
            let values = bernstein(s);
            sums.iter_mut()
                .zip(values)
                .for_each(|(sum, value)| *sum += length * value);
        }
        sums
    }

    /// The points of the rule on a meeting.
    pub fn probes(&self, meeting: &Meeting) -> Vec<Probe> {
        let places = self.places(meeting);
        let face = Face::new(&places, meeting.piece.beside);
        let other = [places[7], places[8], places[9]];
        let [first, last] = meeting.piece.ends.map(|end| end.place());
        let probe = |[at, weight]: &[f64; 2]| {
            let s = first + at * (last - first);
            let [tangent, _] = face.tangent(s);
            let r = meeting_at(&face, s, other)?;
            let along = slope(face.nodes, s);
            Some(Probe {
                s,
                r,
                distance: face.gap(s, other, r) * dot(tangent, tangent).sqrt(),
                length: weight * (last - first) * dot(along, along).sqrt(),
            })
        };
        self.rule.iter().filter_map(probe).collect()
    }

    /// A face of the first surface where it is.
    pub(super) fn face(&self, index: usize) -> Face<f64> {
        let own = &self.pair.carrier.faces[index];
        let beside = own.sides();
        Face::new(&places_of(own, None, self.place), beside)
    }

    /// Where the partner of a meeting is.
    pub(super) fn other_places(&self, meeting: &Meeting) -> [[f64; 2]; 3] {
        self.pair.other.faces[meeting.other].places(self.place)
    }

    /// How pieces are integrated.
    pub(super) fn sweep(&self) -> Sweep<'_> {
        Sweep {
            section: self.pair.section,
            rule: &self.rule,
        }
    }

    pub(super) fn parts<T: Send>(
        &self,
        gaps: &(dyn Fn(&Meeting) -> [T; 3] + Sync),
    ) -> Vec<Part<T>> {
        parallel::map(self.meetings.len(), FEW, &|k| {
            let meeting = &self.meetings[k];
            Part {
                face: meeting.face,
                nodes: self.nodes(meeting),
                gaps: gaps(meeting),
            }
        })
    }

    pub(super) fn nodes(&self, meeting: &Meeting) -> [u32; NODES] {
        let other = &self.pair.other.faces[meeting.other];
        nodes_of(&self.pair.carrier.faces[meeting.face], Some(other))
    }

    pub(super) fn places(&self, meeting: &Meeting) -> NodePlaces<f64> {
        let other = &self.pair.other.faces[meeting.other];
        places_of(
            &self.pair.carrier.faces[meeting.face],
            Some(other),
            self.place,
        )
    }
}

/// Where the ray from `s` meets the other face.
fn meeting_at(face: &Face<f64>, s: f64, other: [[f64; 2]; 3]) -> Option<f64> {
    let [tangent, _] = face.tangent(s);
    meeting(point(face.nodes, s), tangent, other)
}

/// The nodes of a piece; its own ends stand for neighbours that are not there.
fn nodes_of(face: &ChainFace, other: Option<&ChainFace>) -> [u32; NODES] {
    let [a, b, edge] = face.nodes;
    let [before, after] = [0, 1].map(|end| face.beside[end].unwrap_or([a, edge]));
    let [c, d, opposite] = other.map_or(face.nodes, |other| other.nodes);
    [
        a, b, edge, before[0], before[1], after[0], after[1], c, d, opposite,
    ]
}

fn places_of(face: &ChainFace, other: Option<&ChainFace>, place: &PlaceOf<'_>) -> NodePlaces<f64> {
    nodes_of(face, other).map(place)
}

/// The coordinates of all nodes as inputs.
pub(super) fn inputs<T: Number>(
    places: &NodePlaces<f64>,
    input: impl Fn(usize, f64) -> T,
) -> NodePlaces<T> {
    std::array::from_fn(|node| [0, 1].map(|i| input(2 * node + i, places[node][i])))
}

fn in_space([x, y]: [f64; 2]) -> [f64; 3] {
    [x, y, 0.0]
}

/// Bounds of the part of a face that counts: those of the control points of its parabola.
fn bounds_of(partner: &Partner) -> Bounds {
    let [first, last] = partner.range;
    let ends = partner.range.map(|r| point(partner.nodes, r));
    let along = slope(partner.nodes, first);
    let control = [0, 1].map(|i| ends[0][i] + 0.5 * (last - first) * along[i]);
    Bounds::of([ends[0], ends[1], control].map(in_space))
}

/// Bounds of what the rays of a face reach: between two directions each is a sum of both with factors
/// that add up to at most the reciprocal of the cosine of half their angle.
fn swept(face: &Face<f64>, reach: f64) -> Bounds {
    let [a, b, _] = face.nodes;
    let along = slope(face.nodes, 0.0);
    let control = [0, 1].map(|i| a[i] + 0.5 * along[i]);
    let normals = face.tangents.map(|tangent| {
        let size = dot(tangent, tangent).sqrt();
        to_the_right(tangent).map(|x| x / size)
    });
    let sum = [0, 1].map(|i| 0.5 * (normals[0][i] + normals[1][i]));
    let far = reach / dot(sum, sum).sqrt();
    let mut corners = Vec::with_capacity(12);
    for x in [a, b, control] {
        for normal in normals {
            for way in [far, -far] {
                corners.push([x[0] + way * normal[0], x[1] + way * normal[1], 0.0]);
            }
        }
    }
    Bounds::of(corners)
}

/// The rule on \[0, 1\].
fn unit_rule() -> Vec<[f64; 2]> {
    let rule = rule(Simplex::Segment, DEGREE);
    let points = rule.points.iter().zip(&rule.weights);
    points.map(|(point, &weight)| [point[1], weight]).collect()
}
