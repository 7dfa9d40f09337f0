//! How far a surface has slid along another one since the increment began, and what tractions do:
//!
//! ```text
//! f = t(s).(x(s) - y(r)),   t = T / |T|       zero where the ray from s meets r now
//! sigma = t0.(y0(r) - x0(s))                  what is met now, as the face saw it at the start
//! S_j = int psi_j sigma da,   R_j = int psi_j df/du da   (s and r held)
//! dR of tractions = int tau [ (f_uu + f_ur dr/du) da + f_u d(da) ] + [ tau f_u |x'| ds/du ] at its ends,
//! dr/du = -f_u / f_r
//! ```
//!
//! The slip is a place on the other surface, seen from where the face stood when the increment began:
//! it is zero exactly where the same points still are opposite, and motions of all bodies together
//! are none. Where the other surface ends under a face, the end of the piece moves along the face with
//! it; between two of its faces what both their ends give cancels. Forces are derivatives of a number that such motions keep, so that their sum and their
//! moment vanish. Shapes: by face the three functions of its ends and its edge, by piece the
//! coordinates of its ten nodes. Lengths are those of the caller. Cost: of a piece some 30 us, and 0.2
//! ms for the change of its forces.

use std::f64::consts::TAU;

use super::chain::PlaceOf;
use super::number::{First, Number, Second};
use super::pair::{Meeting, Part, Placed, inputs};
use super::piece::{
    End, Face, INPUTS, NODES, NodePlaces, Piece, Section, Sweep, dot, minus, point, slope,
};
use crate::parallel;

/// The coordinates of a piece and the place on the other face.
const WITH_PLACE: usize = INPUTS + 1;
/// Fewer pieces are not worth a second thread; chosen.
const FEW: usize = 4;
/// First of the three nodes of the other face.
const OTHER: usize = 7;

/// What a piece adds to the slips of its face.
#[derive(Clone, Debug)]
pub struct SlipPart {
    /// Number of the face.
    pub face: usize,
    /// Displacement nodes that it depends on.
    pub nodes: [u32; NODES],
    /// S of the three functions.
    pub slips: [f64; 3],
    /// int psi da.
    pub areas: [f64; 3],
    /// int psi t da.
    pub tangents: [[f64; 3]; 2],
    /// R by the coordinates of the nodes.
    pub rows: [[f64; INPUTS]; 3],
}

/// Slips and what tractions act on.
#[derive(Clone, Debug, Default)]
pub struct Sliding {
    /// S `[multipliers * tangents]`, one tangent in the plane, two in space.
    pub slips: Vec<f64>,
    /// int psi da over what has a partner `[multipliers]`.
    pub weights: Vec<f64>,
    /// Unit tangents of the carrier `[multipliers]`; zero where there is none.
    pub frames: Vec<[[f64; 3]; 2]>,
    /// R `[multipliers * tangents]`, columns of all unknowns.
    pub rows: Vec<Vec<(u32, f64)>>,
}

/// What tractions of a piece take off the stiffness `[force][motion]`.
pub type Change = [[f64; INPUTS]; INPUTS];

/// A point of the rule on a piece: s, r and the weight without the length.
pub(super) struct Site {
    pub(super) s: f64,
    pub(super) r: f64,
    pub(super) weight: f64,
}

/// The tangent of unit length.
fn unit<T: Number>(tangent: [T; 2]) -> [T; 2] {
    let size = dot(tangent, tangent).sqrt();
    tangent.map(|x| x / size)
}

/// The nodes of the other face.
fn other_of<T: Number>(places: &NodePlaces<T>) -> [[T; 2]; 3] {
    [places[OTHER], places[OTHER + 1], places[OTHER + 2]]
}

fn constants<T: Number>(places: &NodePlaces<f64>) -> NodePlaces<T> {
    places.map(|place| place.map(T::constant))
}

impl<T: Number> Face<T> {
    /// f of a point `v` of the other face.
    fn apart(&self, s: T, v: [T; 2]) -> T {
        let [tangent, _] = self.tangent(s);
        dot(unit(tangent), minus(point(self.nodes, s), v))
    }

    /// |x'|, times the way around of a body of revolution.
    pub(super) fn stretch(&self, s: T, section: Section) -> T {
        let along = slope(self.nodes, s);
        let length = dot(along, along).sqrt();
        match section {
            Section::Plane => length,
            Section::AboutAxis => (length * point(self.nodes, s)[0]).times(TAU),
        }
    }
}

impl Piece {
    /// S of the three functions, from where the nodes were `before`.
    fn slips<T: Number>(
        &self,
        places: &NodePlaces<T>,
        before: &NodePlaces<f64>,
        sweep: Sweep<'_>,
    ) -> [T; 3] {
        let (face, other) = (Face::new(places, self.beside), other_of(places));
        let start = Face::new(&constants::<T>(before), self.beside);
        let start_other = other_of(&constants::<T>(before));
        let mut sums = [T::constant(0.0); 3];
        let [first, last] = self.ends.map(|end| face.end(end, other));
        for [at, weight] in sweep.rule {
            let s = first + (last - first).times(*at);
            let Some(near) = face.met(s, other) else {
                continue;
            };
            let r = face.hit(s, other, near);
            // That of what the face saw at the start, less where it stood.
            let slid = -start.apart(s, point(start_other, r));
            let area = (last - first).times(*weight) * face.stretch(s, sweep.section);
            let gap = face.gap(s, other, r);
            for (sum, value) in sums.iter_mut().zip(self.counted(&face, s, gap)) {
                *sum = *sum + value * slid * area;
            }
        }
        sums
    }

    /// The points of the rule that have a partner.
    pub(super) fn sites(&self, places: &NodePlaces<f64>, rule: &[[f64; 2]]) -> Vec<Site> {
        let (face, other) = (Face::new(places, self.beside), other_of(places));
        let [first, last] = self.ends.map(|end| face.end(end, other));
        let site = |[at, weight]: &[f64; 2]| {
            let s = first + (last - first) * at;
            let r = face.met(s, other)?;
            let weight = (last - first) * weight;
            Some(Site { s, r, weight })
        };
        rule.iter().filter_map(site).collect()
    }

    /// What counts of the functions at a point.
    pub(super) fn values(&self, face: &Face<f64>, at: &Site, other: [[f64; 2]; 3]) -> [f64; 3] {
        self.counted(face, at.s, face.gap(at.s, other, at.r))
    }

    /// R of the three functions, and int psi (1, t) da.
    fn rows(
        &self,
        places: &NodePlaces<f64>,
        sweep: Sweep<'_>,
    ) -> ([[f64; INPUTS]; 3], [[f64; 3]; 3]) {
        let moving = inputs(places, First::<INPUTS>::input);
        let (face, other) = (Face::new(&moving, self.beside), other_of(&moving));
        let plain = Face::new(places, self.beside);
        let (mut rows, mut areas) = ([[0.0; INPUTS]; 3], [[0.0; 3]; 3]);
        for site in self.sites(places, sweep.rule) {
            let [s, r] = [site.s, site.r].map(Number::constant);
            let apart = face.apart(s, point(other, r));
            let area = site.weight * plain.stretch(site.s, sweep.section);
            let [t, _] = plain.tangent(site.s);
            let [x, y] = unit(t);
            for (j, value) in self
                .values(&plain, &site, other_of(places))
                .into_iter()
                .enumerate()
            {
                for (sum, own) in areas.iter_mut().zip([1.0, x, y]) {
                    sum[j] += value * area * own;
                }
                for (sum, own) in rows[j].iter_mut().zip(&apart.first) {
                    *sum += value * area * own;
                }
            }
        }
        (rows, areas)
    }

    /// dR of `tractions` of the three functions.
    fn change(&self, places: &NodePlaces<f64>, sweep: Sweep<'_>, tractions: [f64; 3]) -> Change {
        let mut change = self.change_inside(places, sweep, tractions);
        let moving = inputs(places, First::<INPUTS>::input);
        let (face, other) = (Face::new(&moving, self.beside), other_of(&moving));
        let plain = Face::new(places, self.beside);
        for (end, sign) in self.ends.into_iter().zip([-1.0, 1.0]) {
            let End::Opposite { r, .. } = end else {
                continue;
            };
            let moved = face.end(end, other);
            let s = Number::constant(moved.value);
            let f = face.apart(s, point(other, Number::constant(r)));
            let stretch = face.stretch(s, sweep.section).value;
            let at = Site {
                s: moved.value,
                r,
                weight: 1.0,
            };
            let values = self.values(&plain, &at, other_of(places));
            let factor = sign * stretch * traction_of(tractions, values);
            for (row, own) in change.iter_mut().zip(f.first) {
                for (entry, by) in row.iter_mut().zip(moved.first) {
                    *entry += factor * own * by;
                }
            }
        }
        change
    }

    /// The same with its ends held.
    fn change_inside(
        &self,
        places: &NodePlaces<f64>,
        sweep: Sweep<'_>,
        tractions: [f64; 3],
    ) -> Change {
        let moving = inputs(places, Second::<WITH_PLACE>::input);
        let (face, other) = (Face::new(&moving, self.beside), other_of(&moving));
        let stretched = Face::new(&inputs(places, First::<INPUTS>::input), self.beside);
        let plain = Face::new(places, self.beside);
        let mut change = [[0.0; INPUTS]; INPUTS];
        for site in self.sites(places, sweep.rule) {
            let s = Second::constant(site.s);
            let r = Second::input(INPUTS, site.r);
            let f = face.apart(s, point(other, r));
            let area = stretched.stretch(First::constant(site.s), sweep.section);
            let values = self.values(&plain, &site, other_of(places));
            let factor = site.weight * traction_of(tractions, values);
            for (k, row) in change.iter_mut().enumerate() {
                // f_r is minus the slope of the other face along the tangent: never zero on a hit.
                let by_place = -f.second_by(k, INPUTS) / f.first[INPUTS];
                for (l, entry) in row.iter_mut().enumerate() {
                    let turned = f.second_by(k, l) + by_place * f.first[l];
                    *entry += factor * (turned * area.value + f.first[k] * area.first[l]);
                }
            }
        }
        change
    }
}

/// The traction of three functions by their values.
fn traction_of(tractions: [f64; 3], values: [f64; 3]) -> f64 {
    let values = values.into_iter().zip(tractions);
    values.map(|(value, own)| value * own).sum()
}

impl Placed<'_> {
    /// S, areas and R of each meeting, from where nodes were at `start`.
    pub fn slid(&self, start: &PlaceOf<'_>) -> Vec<SlipPart> {
        parallel::map(self.meetings.len(), FEW, &|k| {
            let meeting = &self.meetings[k];
            let (places, nodes) = (self.places(meeting), self.nodes(meeting));
            let (rows, [areas, x, y]) = meeting.piece.rows(&places, self.sweep());
            SlipPart {
                face: meeting.face,
                nodes,
                slips: meeting
                    .piece
                    .slips(&places, &nodes.map(start), self.sweep()),
                areas,
                tangents: [x, y],
                rows,
            }
        })
    }

    /// S of each meeting with its derivatives by the coordinates of its nodes.
    pub fn slips_first(&self, start: &PlaceOf<'_>) -> Vec<Part<First<INPUTS>>> {
        self.parts(&|meeting: &Meeting| {
            let places = inputs(&self.places(meeting), First::input);
            let before = self.nodes(meeting).map(start);
            meeting.piece.slips(&places, &before, self.sweep())
        })
    }

    /// dR of `tractions` `[faces]`, of those meetings whose face has some.
    pub fn traction_changes(&self, tractions: &[[f64; 3]]) -> Vec<([u32; NODES], Box<Change>)> {
        let all = self.meetings.iter();
        let loaded: Vec<&Meeting> = all
            .filter(|meeting| tractions[meeting.face].iter().any(|&own| own != 0.0))
            .collect();
        parallel::map(loaded.len(), 1, &|k| {
            let meeting = loaded[k];
            let tractions = tractions[meeting.face];
            let change = meeting
                .piece
                .change(&self.places(meeting), self.sweep(), tractions);
            (self.nodes(meeting), Box::new(change))
        })
    }
}
