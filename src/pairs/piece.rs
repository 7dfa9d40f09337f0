//! The gap between a piece of a face and a piece of the other surface, in the plane:
//!
//! ```text
//! T(s) = (1-s) T_a + s T_b,   T_a = unit tangent before a + unit tangent after a,   n = (T_2, -T_1)
//! T.(x(s) - y(r)) = 0,   g = n.(y - x) / (n.n),   a = g n x x' + g^2/2 n x n'
//! G_j = int psi_j a ds   from one end of the piece to the other
//! ```
//!
//! x, y quadratic along an edge, s and r in \[0, 1\]; bodies lie to the left of their edges, so that n
//! points out of the body. a ds is the area that the rays along n sweep from x to y: over all pieces
//! the G_j of functions that add up to one add up to the area between the surfaces. An end of a piece
//! stands still, or moves with a vertex of the other surface:
//!
//! ```text
//! T(s).(x(s) - y(r_v)) = 0
//! ```
//!
//! About an axis a ds is the volume of the full turn, with (x + t n)_1 the radius on the ray:
//!
//! ```text
//! a = 2 pi int (x + t n)_1 (n x x' + t n x n') dt   from 0 to g
//! ```
//!
//! Everything is written for any [`Number`]; with derivatives, roots are refined by two steps of
//! Newton's method in these numbers, so that the derivatives are those of the sum over the points of
//! the rule itself, the motion of its ends included. Lengths are those of the caller, G_j areas. Cost:
//! some 80 products a point.

use std::f64::consts::TAU;

use super::number::Number;

/// Nodes that a piece depends on: see [`NodePlaces`].
pub const NODES: usize = 10;
/// Coordinates of these nodes.
pub const INPUTS: usize = 2 * NODES;

/// Where the nodes of a piece are: ends a, b and edge of the face, outer end and edge of its
/// neighbour before a, the same after b, ends and edge of the other face. The value of an edge is
/// that of its middle less the mean of its ends.
pub type NodePlaces<T> = [[T; 2]; NODES];

/// First of the three nodes of the other face.
pub(super) const OTHER: usize = 7;

/// An end of a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// At s, whatever moves.
    Fixed(f64),
    /// Opposite to the place r of the other face, at s now.
    Opposite {
        /// Place on the face.
        s: f64,
        /// Place on the other face.
        r: f64,
    },
}

impl End {
    /// Where it is on the face.
    pub fn place(self) -> f64 {
        match self {
            Self::Fixed(s) | Self::Opposite { s, .. } => s,
        }
    }
}

/// What the plane is a section of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Section {
    /// A body of constant section, per unit thickness.
    #[default]
    Plane,
    /// A body of revolution about x = 0: volumes are those of the full turn.
    AboutAxis,
}

/// What gives the normal at an end of a face beside the face itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Beside {
    /// Nothing: it goes straight on.
    #[default]
    Nothing,
    /// The next face.
    Face,
    /// A wall along which the end is held, by its normal in the direction of the face: the body is its
    /// own mirror image there, and rays along it leave no part of the gap out.
    Wall([i8; 2]),
}

/// How a piece is integrated.
#[derive(Clone, Copy, Debug)]
pub struct Sweep<'a> {
    /// Of which body the plane is a section.
    pub section: Section,
    /// Places and weights on \[0, 1\].
    pub rule: &'a [[f64; 2]],
}

/// A part of a face that has one partner.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// What gives the normals at a and b beside the face itself.
    pub beside: [Beside; 2],
    /// The ends, ascending.
    pub ends: [End; 2],
    /// kappa of the three functions (see `fading`).
    pub fading: [f64; 3],
}

/// a . b
pub(super) fn dot<T: Number>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[0] + a[1] * b[1]
}

/// The third component of a x b.
pub(super) fn cross<T: Number>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn minus<T: Number>(a: [T; 2], b: [T; 2]) -> [T; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// n of a tangent, to its right.
pub(super) fn to_the_right<T: Number>(tangent: [T; 2]) -> [T; 2] {
    [tangent[1], -tangent[0]]
}

/// The point at `s` of an edge by its ends and middle.
pub(super) fn point<T: Number>([a, b, middle]: [[T; 2]; 3], s: T) -> [T; 2] {
    let bulge = (s * (T::constant(1.0) - s)).times(4.0);
    [0, 1].map(|i| a[i] + s * (b[i] - a[i]) + bulge * middle[i])
}

/// The derivative of [`point`] by `s`.
pub(super) fn slope<T: Number>([a, b, middle]: [[T; 2]; 3], s: T) -> [T; 2] {
    let bulge = (T::constant(1.0) - s.times(2.0)).times(4.0);
    [0, 1].map(|i| b[i] - a[i] + bulge * middle[i])
}

fn unit<T: Number>(tangent: [T; 2]) -> [T; 2] {
    let size = dot(tangent, tangent).sqrt();
    tangent.map(|x| x / size)
}

/// A face with the tangents at its ends.
#[derive(Clone, Copy)]
pub(super) struct Face<T> {
    /// Ends and edge.
    pub(super) nodes: [[T; 2]; 3],
    /// T_a and T_b.
    pub(super) tangents: [[T; 2]; 2],
}

impl<T: Number> Face<T> {
    /// Of the first seven places, of which neighbours count where they are `beside`.
    pub(super) fn new(places: &NodePlaces<T>, beside: [Beside; 2]) -> Self {
        let [a, b, middle, before, middle_before, after, middle_after, ..] = *places;
        let nodes = [a, b, middle];
        let neighbours = [[before, a, middle_before], [b, after, middle_after]];
        let tangents = [0, 1].map(|end| {
            let at = |s: f64| T::constant(s);
            let own = unit(slope(nodes, at(end as f64)));
            let other = match beside[end] {
                Beside::Nothing => own,
                Beside::Face => unit(slope(neighbours[end], at(1.0 - end as f64))),
                Beside::Wall(along) => return along.map(|x| at(2.0 * f64::from(x))),
            };
            [own[0] + other[0], own[1] + other[1]]
        });
        Self { nodes, tangents }
    }

    /// T at `s`, and its derivative.
    pub(super) fn tangent(&self, s: T) -> [[T; 2]; 2] {
        let [a, b] = self.tangents;
        let change = minus(b, a);
        [[0, 1].map(|i| a[i] + s * change[i]), change]
    }

    /// T.(x - v) at `s`, and its derivative.
    fn along(&self, s: T, v: [T; 2]) -> [T; 2] {
        let [tangent, change] = self.tangent(s);
        let apart = minus(point(self.nodes, s), v);
        let turned = dot(change, apart);
        [
            dot(tangent, apart),
            dot(tangent, slope(self.nodes, s)) + turned,
        ]
    }

    /// Where an end is.
    pub(super) fn end(&self, end: End, other: [[T; 2]; 3]) -> T {
        match end {
            End::Fixed(s) => T::constant(s),
            End::Opposite { s, r } => {
                let v = point(other, T::constant(r));
                let step = |s: T| {
                    let [value, slope] = self.along(s, v);
                    s - value / slope
                };
                (0..T::STEPS).fold(T::constant(s), |s, _| step(s))
            }
        }
    }

    /// The value of where the ray from `s` meets the other face; none where it misses.
    pub(super) fn met(&self, s: T, other: [[T; 2]; 3]) -> Option<f64> {
        let plain = |node: [T; 2]| node.map(|x| x.value());
        let [tangent, _] = self.tangent(s);
        meeting(
            plain(point(self.nodes, s)),
            plain(tangent),
            other.map(plain),
        )
    }

    /// Where the ray from `s` meets the other face, near `r`.
    pub(super) fn hit(&self, s: T, other: [[T; 2]; 3], r: f64) -> T {
        let [tangent, _] = self.tangent(s);
        let x = point(self.nodes, s);
        let step = |r: T| {
            let apart = dot(tangent, minus(x, point(other, r)));
            r + apart / dot(tangent, slope(other, r))
        };
        (0..T::STEPS).fold(T::constant(r), |r, _| step(r))
    }

    /// g on the ray from `s` to the place `r` of the other face.
    pub(super) fn gap(&self, s: T, other: [[T; 2]; 3], r: T) -> T {
        let [tangent, _] = self.tangent(s);
        let n = to_the_right(tangent);
        let apart = minus(point(other, r), point(self.nodes, s));
        dot(n, apart) / dot(n, n)
    }

    /// a, what the ray from `s` sweeps over a gap.
    fn area(&self, (s, gap): (T, T), section: Section) -> T {
        let [tangent, change] = self.tangent(s);
        let (n, bent) = (to_the_right(tangent), to_the_right(change));
        let [along, turning] = [cross(n, slope(self.nodes, s)), cross(n, bent)];
        let swept = gap * along;
        let turned = (gap * gap * turning).times(0.5);
        if section == Section::AboutAxis {
            // int 2 pi (x + t n)_1 (along + t turning) dt from 0 to g
            let outwards =
                (gap * gap * along).times(0.5) + (gap * gap * gap * turning).times(1.0 / 3.0);
            let radius = point(self.nodes, s)[0];
            return (radius * (swept + turned) + n[0] * outwards).times(TAU);
        }
        swept + turned
    }
}

/// Where the line along `n` through `x` meets an edge, near its middle; none where it does not.
pub(super) fn meeting(
    x: [f64; 2],
    tangent: [f64; 2],
    [c, d, middle]: [[f64; 2]; 3],
) -> Option<f64> {
    let bend = 4.0 * dot(tangent, middle);
    let slope = -dot(tangent, minus(d, c)) - bend;
    let apart = dot(tangent, minus(x, c));
    let root = (slope * slope - 4.0 * bend * apart).sqrt();
    // The root that stays where the edge becomes straight.
    let r = -2.0 * apart / (slope + root.copysign(slope));
    r.is_finite().then_some(r)
}

impl Piece {
    /// int psi_j a ds of the three Bernstein functions of the face, those of a, b and its edge.
    pub fn gaps<T: Number>(&self, places: &NodePlaces<T>, sweep: Sweep<'_>) -> [T; 3] {
        let mut sums = [T::constant(0.0); 3];
        self.each_point(places, sweep, &mut |values, weighted| {
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum = *sum + value * weighted;
            }
        });
        sums
    }

    /// sum_j factor_j G_j.
    pub fn weighted<T: Number>(
        &self,
        places: &NodePlaces<T>,
        sweep: Sweep<'_>,
        factors: [f64; 3],
    ) -> T {
        let mut sum = T::constant(0.0);
        self.each_point(places, sweep, &mut |[a, b, middle], weighted| {
            let factor = a.times(factors[0]) + b.times(factors[1]) + middle.times(factors[2]);
            sum = sum + factor * weighted;
        });
        sum
    }

    /// What counts of the functions, and a times the weight, at every point of the rule.
    fn each_point<T: Number>(
        &self,
        places: &NodePlaces<T>,
        sweep: Sweep<'_>,
        see: &mut dyn FnMut([T; 3], T),
    ) {
        let face = Face::new(places, self.beside);
        let other = [places[OTHER], places[OTHER + 1], places[OTHER + 2]];
        let [first, last] = self.ends.map(|end| face.end(end, other));
        let length = last - first;
        for [at, weight] in sweep.rule {
            let s = first + length.times(*at);
            let weight = length.times(*weight);
            let Some(near) = face.met(s, other) else {
                continue;
            };
            let r = face.hit(s, other, near);
            let gap = face.gap(s, other, r);
            let values = self.counted(&face, s, gap);
            see(values, weight * face.area((s, gap), sweep.section));
        }
    }
}

/// (1-s)^2, s^2, 2 s (1-s).
pub(super) fn bernstein<T: Number>(s: T) -> [T; 3] {
    let rest = T::constant(1.0) - s;
    [rest * rest, s * s, (s * rest).times(2.0)]
}
