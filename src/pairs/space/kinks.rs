//! What the motion of the borders between pieces adds to second derivatives of gaps.
//!
//! Where one partner ends and the next one begins the gap is continuous and has a kink. With
//! phi = g_before - g_after the border is where phi = 0, and moves by -dphi / |grad phi| across
//! itself, so that
//!
//! ```text
//! d2G = sum over pieces of int psi d2a  -  sum over borders of int psi a_g dphi^2 / (n.grad phi) dl
//! ```
//!
//! n out of the piece before. At a sharp kink this is all the curvature that there is. Where a surface
//! ends see [`super::rims`]. Shapes: dphi by twenty-one vectors, nine of the
//! face and six of each partner. Cost: a border is known by its two ends, three points each.

use super::choice::Piece;
use super::outline::sides;
use super::patch::{At, NODES, Patch, bernstein};
use super::point::{OTHER, Point};
use super::rays::Rayed;
use crate::geometry::vector3::{add, dot, scale};

/// Vectors that a border depends on.
pub(super) const VECTORS: usize = OTHER + 2 * NODES;
/// How far ends of one border may be apart, in face coordinates.
const SAME: f64 = 1e-8;
/// Kinks below this are none, in slopes of the gap by face coordinates over the size of the face.
const FLAT: f64 = 1e-9;
/// Places and weights of Gauss's rule on \[0, 1\] of degree five.
const RULE: [[f64; 2]; 3] = [
    [0.112_701_665_379_258_3, 5.0 / 18.0],
    [0.5, 8.0 / 18.0],
    [0.887_298_334_620_741_7, 5.0 / 18.0],
];

/// A border between two pieces of a face: it runs around the first one counterclockwise.
#[derive(Clone, Copy, Debug)]
pub(super) struct Border {
    /// Both pieces.
    pub(super) pieces: [usize; 2],
    ends: [At; 2],
    bulge: At,
}

/// dphi of a point of a border, and the factor of its square.
pub(super) struct Kink {
    /// By the vectors.
    pub(super) slope: [[f64; 3]; VECTORS],
    /// Factor.
    pub(super) factor: f64,
}

fn is_same(a: At, b: At) -> bool {
    (0..2).all(|i| (a[i] - b[i]).abs() <= SAME)
}

/// The borders between pieces with different partners, each once.
pub(super) fn borders(pieces: &[Piece]) -> Vec<Border> {
    let mut found = Vec::new();
    for (k, first) in pieces.iter().enumerate() {
        let corners = first.polygon.iter().zip(sides(&first.polygon));
        // Lines beyond rims move on their own.
        let inside = corners.filter(|(corner, _)| corner.rim.is_none());
        let inside = inside.map(|(_, side)| side);
        for (ends, bulge) in inside.filter(|([a, b], _)| !is_same(*a, *b)) {
            let others = pieces.iter().enumerate().skip(k + 1);
            let beyond = others.filter(|(_, second)| second.other != first.other);
            let mut beyond = beyond.filter(|(_, second)| {
                sides(&second.polygon).any(|([a, b], _)| is_same(a, ends[1]) && is_same(b, ends[0]))
            });
            if let Some((other, _)) = beyond.next() {
                found.push(Border {
                    pieces: [k, other],
                    ends,
                    bulge,
                });
            }
        }
    }
    found
}

impl Border {
    /// The kinks at its points on `face` between two partners, of sum_j factor_j G_j.
    pub(super) fn kinks(
        &self,
        face: &Rayed,
        partners: [&Patch; 2],
        factors: [f64; NODES],
    ) -> Vec<Kink> {
        let [a, b] = self.ends;
        let m = self.bulge;
        let kink = |[s, weight]: &[f64; 2]| {
            let rise = 4.0 * s * (1.0 - s);
            let at = [0, 1].map(|i| a[i] + s * (b[i] - a[i]) + rise * m[i]);
            let along = [0, 1].map(|i| b[i] - a[i] + 4.0 * (1.0 - 2.0 * s) * m[i]);
            let points = [
                Point::new(face, at, partners[0])?,
                Point::new(face, at, partners[1])?,
            ];
            let values = bernstein(at).into_iter().zip(factors);
            let factor: f64 = values.map(|(value, factor)| value * factor).sum();
            let slope = apart(&points, partners);
            // n.grad phi times the slope of the border
            let steep = [0, 1].map(|k| points[k].gap_slopes(partners[k]));
            let jump = [0, 1].map(|i| steep[0][i] - steep[1][i]);
            let across = along[1] * jump[0] - along[0] * jump[1];
            let size = along[0].hypot(along[1]);
            if across.abs() <= FLAT * size * points[0].size() {
                return None;
            }
            let by_gap = 0.5 * (points[0].swept_by_gap() + points[1].swept_by_gap());
            Some(Kink {
                slope,
                factor: -weight * factor * by_gap * size * size / across,
            })
        };
        RULE.iter().filter_map(kink).collect()
    }
}

/// dphi by the vectors.
fn apart(points: &[Point; 2], partners: [&Patch; 2]) -> [[f64; 3]; VECTORS] {
    let mut slope = [[0.0; 3]; VECTORS];
    for (k, sign) in [1.0, -1.0].into_iter().enumerate() {
        let own = points[k].gap_gradient(partners[k]);
        for (vector, own) in own.into_iter().enumerate() {
            let place = if vector < OTHER {
                vector
            } else {
                vector + k * NODES
            };
            slope[place] = add(slope[place], scale(sign, own));
        }
    }
    slope
}

impl Point {
    /// Derivative of g by the vectors.
    fn gap_gradient(&self, other: &Patch) -> [[f64; 3]; super::point::VECTORS] {
        let (down, _) = self.across(other);
        self.factors().map(|factors| scale(factors[0], down))
    }

    /// g_,1 and g_,2 along the face.
    pub(super) fn gap_slopes(&self, other: &Patch) -> [f64; 2] {
        let (down, _) = self.across(other);
        self.carried().map(|along| dot(down, along))
    }

    /// Length of the face.
    fn size(&self) -> f64 {
        let [first, second] = self.carried();
        (dot(first, first) + dot(second, second)).sqrt()
    }
}
