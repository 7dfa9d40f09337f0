//! What is open beside a corner of the other surface makes no room for what is closed on its other side.
//!
//! A corner of more than 60 degrees parts the other surface. A function whose faces meet
//! several of them, the sole and a wall of a block say, has one multiplier for all: where the wall is far, the
//! gap to it would let the sole go in until the sum of both is zero. So the gap to each counts by
//!
//! ```text
//! g -> g [1 - kappa_jS o(g)],   o = 0 up to half of d, 1 from d on, between by q^2 (3 - 2 q),  d .03 of the face
//! kappa_jS = a(c_jS) p^2 (3 - 2 p),   p = (m_jS - least of m_jS) / d, at most one,   m_jS = int psi_j dV / int psi_j da
//! ```
//!
//! c the mean cosine at which rays meet the part, a 1 below .7, 0 from .8 on, between as o: a wall, not the flank
//! of a tip, whose sides press both. Integrals are over what the function j meets of the part S. The part that is nearest counts wholly, and so does each
//! other one where it is near; of the rest nothing is left, as if the other surface ended at the corner. o is
//! a part of what is integrated, with its derivatives; kappa is taken as it is, and pieces end where o begins
//! and where it is one. Functions that meet one part have kappa = 0. In the plane and about an axis,
//! between bodies. Cost: gaps of functions that meet several parts.

use std::collections::BTreeMap;

use super::chain::{Chain, by_vertex, turn};
use super::choice::{SHORTEST, crossing};
use super::number::Number;
use super::pair::{Meeting, Placed};
use super::piece::{End, Face, Piece, bernstein, dot, meeting, point, slope};
use crate::contact::shares::Shares;
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Gap over the length of a face from which on nothing of it counts, without unit; chosen: with .03 a block with walls
/// takes 15 programs in one increment, with .1 it does not converge.
const FADED: f64 = 0.03;
/// Share of that from which on it fades, without unit; chosen.
const BEGINS: f64 = 0.5;
/// Cosine of the turn at a corner below which it parts a surface, without unit; chosen: walls of blocks are beyond
/// such corners, chamfers and flanks of blunt tips are not.
const STEEP: f64 = 0.5;
/// Cosines between rays and the normals of a part below which it begins to fade, and fades wholly, without unit;
/// chosen: below .6 and .4 walls of blocks that are pressed deep make room again (1.229 for 1.386), flanks of a
/// wedge of 67 degrees are met at .83.
const WALL: [f64; 2] = [0.8, 0.7];
/// Parts of a piece in each of which it is looked for where the gap begins to fade and has faded; chosen.
const PARTS: u32 = 8;

/// The part that each face of a surface is of `[faces]`: all that is joined without a steep corner.
pub(super) fn parts(mesh: &Mesh, space: &TaylorHood, chain: &Chain) -> Vec<u32> {
    let starts = by_vertex(&chain.faces, 0);
    let mut parts: Vec<u32> = (0..).take(chain.faces.len()).collect();
    for (face, own) in chain.faces.iter().enumerate() {
        let Some(next) = starts.get(&own.nodes[1]).copied().flatten() else {
            continue;
        };
        if turn(mesh, space, [own.nodes, chain.faces[next].nodes]) >= STEEP {
            let [kept, gone] = [parts[face].min(parts[next]), parts[face].max(parts[next])];
            let joined = parts.iter_mut().filter(|part| **part == gone);
            joined.for_each(|part| *part = kept);
        }
    }
    parts
}

/// From 0 at 0 to 1 at 1, level there.
fn rise<T: Number>(p: T) -> T {
    match p.value() {
        value if value <= 0.0 => T::constant(0.0),
        value if value >= 1.0 => T::constant(1.0),
        _ => p * p * (T::constant(3.0) - p.times(2.0)),
    }
}

impl<T: Number> Face<T> {
    /// The length of a gap in units of what is open, times its sign, squared.
    fn openness(&self, s: T, gap: T) -> T {
        let [tangent, _] = self.tangent(s);
        let along = slope(self.nodes, T::constant(0.5));
        let square = gap * gap * dot(tangent, tangent) / dot(along, along);
        square.times((FADED * FADED).recip().copysign(gap.value()))
    }

    /// o of a gap.
    fn out(&self, s: T, gap: T) -> T {
        let begins = BEGINS * BEGINS;
        let past = self.openness(s, gap) - T::constant(begins);
        rise(past.times((1.0 - begins).recip()))
    }
}

impl Piece {
    /// Whether something of it is left out.
    pub(super) fn fades(&self) -> bool {
        self.fading.iter().any(|own| *own > 0.0)
    }

    /// What of the gap to a smooth part counts for the three functions, times these, at `s`.
    pub(super) fn counted<T: Number>(&self, face: &Face<T>, s: T, gap: T) -> [T; 3] {
        let values = bernstein(s);
        if !self.fades() {
            return values;
        }
        let out = face.out(s, gap);
        [0, 1, 2].map(|k| values[k] * (T::constant(1.0) - out.times(self.fading[k])))
    }
}

/// What parts the gaps of multipliers.
#[derive(Clone, Copy)]
pub(super) struct Known<'a> {
    /// Functions of the carrier's faces `[faces]`.
    pub(super) functions: &'a [[u32; 3]],
    /// The part of each face of the other surface `[faces]`.
    pub(super) parts: &'a [u32],
    /// Which multipliers stand for which functions.
    pub(super) shares: &'a Shares,
}

/// Sums of a multiplier over what it meets of a smooth part: int psi g, int psi c, int psi.
type Sums = BTreeMap<(u32, u32), [f64; 3]>;

impl Placed<'_> {
    /// The same with what is open left out of multipliers that meet something nearer beyond a corner.
    pub(super) fn fading(mut self, known: Known<'_>) -> Self {
        let factors = self.factors(known);
        if factors.is_empty() {
            return self;
        }
        let meetings = std::mem::take(&mut self.meetings);
        for meeting in meetings {
            let part = known.parts[meeting.other];
            let factor = |(m, _): (u32, f64)| factors.get(&(m, part)).copied().unwrap_or(0.0);
            let of = |function: u32| known.shares.of(function).map(factor).fold(0.0, f64::max);
            let fading = known.functions[meeting.face].map(of);
            let piece = Piece {
                fading,
                ..meeting.piece
            };
            let whole = Meeting { piece, ..meeting };
            if piece.fades() {
                let cut = self.cut(&whole);
                self.meetings.extend(cut);
            } else {
                self.meetings.push(whole);
            }
        }
        self
    }

    /// kappa by multiplier and part, where it is not zero.
    fn factors(&self, known: Known<'_>) -> BTreeMap<(u32, u32), f64> {
        let sums = self.sums(known);
        let mut least: BTreeMap<u32, f64> = BTreeMap::new();
        let means = sums
            .into_iter()
            .map(|(key, [gap, cosine, area])| (key, [gap / area, cosine / area]));
        let means: Vec<((u32, u32), [f64; 2])> = means.collect();
        for &((m, _), [mean, _]) in &means {
            let known = least.entry(m).or_insert(mean);
            *known = known.min(mean);
        }
        let open = self.open(known, &least);
        let factor = |((m, part), [mean, cosine]): ((u32, u32), [f64; 2])| {
            let beyond = (mean - least.get(&m)?) / open.get(&m)?;
            let aslant = (cosine - WALL[0]) / (WALL[1] - WALL[0]);
            let own = rise(aslant) * rise(beyond);
            Some(((m, part), own)).filter(|&(_, own)| own > 0.0)
        };
        means.into_iter().filter_map(factor).collect()
    }

    /// Sums of the multipliers that meet several parts.
    fn sums(&self, known: Known<'_>) -> Sums {
        let mut met: BTreeMap<u32, (u32, bool)> = BTreeMap::new();
        for meeting in &self.meetings {
            let part = known.parts[meeting.other];
            let own = known.functions[meeting.face].into_iter();
            for (m, _) in own.flat_map(|function| known.shares.of(function)) {
                let (first, several) = met.entry(m).or_insert((part, false));
                *several |= *first != part;
            }
        }
        met.retain(|_, (_, several)| *several);
        let mut sums = Sums::new();
        for meeting in &self.meetings {
            let own = known.functions[meeting.face];
            let wanted = |k: usize| known.shares.of(own[k]).filter(|(m, _)| met.contains_key(m));
            if (0..3).all(|k| wanted(k).next().is_none()) {
                continue;
            }
            let gaps = meeting.piece.gaps(&self.places(meeting), self.sweep());
            let areas = self.counted_areas(meeting);
            let cosine = self.squareness(meeting);
            for k in 0..3 {
                for (m, share) in wanted(k) {
                    let sum = sums.entry((m, known.parts[meeting.other])).or_default();
                    let parts = [gaps[k], cosine * areas[k], areas[k]];
                    *sum = [0, 1, 2].map(|i| sum[i] + share * parts[i]);
                }
            }
        }
        sums.retain(|_, [_, _, area]| *area > 0.0);
        sums
    }

    /// Cosine between the ray from the middle of a meeting and the normal of what it meets.
    fn squareness(&self, meeting: &Meeting) -> f64 {
        let (face, other) = (self.face(meeting.face), self.other_places(meeting));
        let [first, last] = meeting.piece.ends.map(End::place);
        let s = 0.5 * (first + last);
        let [tangent, _] = face.tangent(s);
        meeting_of(&face, s, other).map_or(1.0, |r| {
            let met = slope(other, r);
            -dot(tangent, met) / (dot(tangent, tangent) * dot(met, met)).sqrt()
        })
    }

    /// From which gap on the `wanted` multipliers are open, by the longest of their faces.
    fn open(&self, known: Known<'_>, wanted: &BTreeMap<u32, f64>) -> BTreeMap<u32, f64> {
        let mut open: BTreeMap<u32, f64> = BTreeMap::new();
        for (face, own) in known.functions.iter().enumerate() {
            let all = own.iter().flat_map(|&function| known.shares.of(function));
            for (m, _) in all.filter(|(m, _)| wanted.contains_key(m)) {
                let along = slope(self.face(face).nodes, 0.5);
                let longest = open.entry(m).or_insert(0.0);
                *longest = longest.max(FADED * dot(along, along).sqrt());
            }
        }
        open
    }

    /// A meeting in parts that end where its gap begins to fade and where nothing is left of it.
    fn cut(&self, meeting: &Meeting) -> Vec<Meeting> {
        let (face, other) = (self.face(meeting.face), self.other_places(meeting));
        let openness = |s: f64| {
            let met = meeting_of(&face, s, other);
            met.map_or(f64::INFINITY, |r| face.openness(s, face.gap(s, other, r)))
        };
        let ends = meeting.piece.ends;
        let [first, last] = ends.map(End::place);
        let mut cuts: Vec<f64> = Vec::new();
        for level in [BEGINS * BEGINS, 1.0] {
            for part in 0..PARTS {
                let at = |k: u32| first + (last - first) * f64::from(k) / f64::from(PARTS);
                cuts.extend(crossing(&|s| openness(s) > level, [at(part), at(part + 1)]));
            }
        }
        cuts.retain(|s| *s - first > SHORTEST && last - *s > SHORTEST);
        cuts.sort_by(f64::total_cmp);
        let mut marks = vec![ends[0]];
        marks.extend(cuts.into_iter().map(End::Fixed));
        marks.push(ends[1]);
        let own = marks.windows(2).map(|pair| Meeting {
            piece: Piece {
                ends: [pair[0], pair[1]],
                ..meeting.piece
            },
            ..*meeting
        });
        own.collect()
    }
}

/// Where the ray from `s` meets the other face.
fn meeting_of(face: &Face<f64>, s: f64, other: [[f64; 2]; 3]) -> Option<f64> {
    let [tangent, _] = face.tangent(s);
    meeting(point(face.nodes, s), tangent, other)
}
