//! What the motion of the lines beyond the rims of the other surface adds to derivatives of gaps.
//!
//! There pieces end, and their ends move with the other surface:
//!
//! ```text
//! dG = sum over pieces of int psi da  +  int psi a w ds
//! d2G = ... + int psi [ da w + w da + (a_,n / |t|) w w ] ds
//! w = t_2 dl_1 - t_1 dl_2 = c.e,   e = dx + g dn - dY,   c = (t_1 n x X_1 - t_2 X_2 x n) / n.(X_1 x X_2)
//! ```
//!
//! t = dl/ds along the line counterclockwise around the piece, Y the point of the line that the ray
//! passes, g the distance there. Between two pieces of one line the gap has a jump, where one face goes
//! on differently from the next, and both add their own. Of second derivatives the parts with a itself
//! are left out: where the surface presses the gap is small, and zero in the mean. Shapes: by
//! vectors, nodes and normals of the face, then the nodes that Y depends on. Cost: five points a side.

use super::choice::Piece;
use super::normals::Vector;
use super::outline::Rim;
use super::pair::Placed;
use super::patch::{At, NODES, bernstein, values};
use super::point::{OTHER, Point};
use super::rays::Rayed;
use crate::element::quadrature::{Simplex, rule};
use crate::geometry::vector3::{add, cross, dot, scale, sub};

/// Degree of the rule along a line.
const DEGREE: u32 = 9;
/// Vectors that w depends on: those of the face, and three nodes each of both ends of the line.
pub(super) const VECTORS: usize = OTHER + 6;
/// Lines along which rays run are left out: cosines below this.
const ALONG: f64 = 1e-9;

/// A point of such a line.
pub(super) struct RimPoint {
    pub(super) site: Site,
    /// What its ray has swept on the face of the partner.
    pub(super) point: Point,
    /// w by vectors.
    pub(super) motion: [(Vector, [f64; 3]); VECTORS],
}

/// Where on a line.
#[derive(Clone, Copy)]
pub(super) struct Site {
    /// Place on the face.
    pub(super) at: At,
    /// t.
    along: At,
    /// Weight along the line.
    pub(super) weight: f64,
}

/// What a point adds to second derivatives: factor (p q + q p).
pub(super) struct RimBend {
    /// p.
    pub(super) change: Vec<(Vector, [f64; 3])>,
    /// q.
    pub(super) motion: [(Vector, [f64; 3]); VECTORS],
    /// Factor.
    pub(super) factor: f64,
}

impl Placed<'_> {
    /// The points of the lines at which a piece of a face ends.
    pub(super) fn rim_points(&self, face: usize, piece: &Piece) -> Vec<RimPoint> {
        let after = piece.polygon.iter().cycle().skip(1);
        let mut points = Vec::new();
        for (corner, next) in piece.polygon.iter().zip(after) {
            let Some(rim) = corner.rim else {
                continue;
            };
            let rule = rule(Simplex::Segment, DEGREE);
            for (l, weight) in rule.points.iter().zip(&rule.weights) {
                let s = l[1];
                let ([a, b], m) = ([corner.at, next.at], corner.bulge);
                let rise = 4.0 * s * (1.0 - s);
                let at = [0, 1].map(|i| a[i] + s * (b[i] - a[i]) + rise * m[i]);
                let along = [0, 1].map(|i| b[i] - a[i] + 4.0 * (1.0 - 2.0 * s) * m[i]);
                let site = Site {
                    at,
                    along,
                    weight: *weight,
                };
                points.extend(self.rim_point((face, piece), (rim, s), site));
            }
        }
        points
    }

    fn rim_point(
        &self,
        (face, piece): (usize, &Piece),
        (rim, s): (Rim, f64),
        site: Site,
    ) -> Option<RimPoint> {
        let Site { at, along, .. } = site;
        let own = &self.own[face];
        let point = Point::new(own, at, &self.others[piece.other])?;
        let (nodes, y) = self.passed(piece.other, rim, s);
        let ray = own.ray(at);
        let gap = dot(ray.along, sub(y, ray.from)) / dot(ray.along, ray.along);
        let across = across(own, (at, gap), along)?;
        let vectors = self.vectors(face, piece);
        let shares = values(at);
        let hats = [1.0 - at[0] - at[1], at[0], at[1]];
        let motion = std::array::from_fn(|k| match k {
            0..NODES => (vectors[k], scale(shares[k], across)),
            NODES..OTHER => (vectors[k], scale(gap * hats[k - NODES], across)),
            _ => {
                let (node, share) = nodes[k - OTHER];
                (Vector::Node(node), scale(-share, across))
            }
        });
        Some(RimPoint {
            site,
            point,
            motion,
        })
    }

    /// Y at a share of a part of a line beyond a face, and the nodes that it moves with.
    fn passed(&self, other: usize, rim: Rim, s: f64) -> ([(u32, f64); 6], [f64; 3]) {
        let skin = &self.pair.other;
        let share = rim.part[0] + s * (rim.part[1] - rim.part[0]);
        let (mut nodes, mut place) = ([(0, 0.0); 6], [0.0; 3]);
        for (end, part) in [1.0 - share, share].into_iter().enumerate() {
            let (face, shares) = skin.spot(other, rim.ends[end]);
            for (k, own) in shares.into_iter().enumerate() {
                nodes[3 * end + k] = (skin.faces[face].nodes[k], part * own);
                place = add(place, scale(part * own, self.others[face].nodes[k]));
            }
        }
        (nodes, place)
    }
}

/// c at a place of a face for what is `gap` away and runs along t; none where rays run along the face.
fn across(own: &Rayed, (at, gap): (At, f64), along: At) -> Option<[f64; 3]> {
    let n = own.normal(at);
    let [t1, t2] = own.turns();
    let [x1, x2] = own.patch.tangents(at);
    let [x1, x2] = [add(x1, scale(gap, t1)), add(x2, scale(gap, t2))];
    let size = dot(n, cross(x1, x2));
    let across = sub(scale(along[0], cross(n, x1)), scale(along[1], cross(x2, n)));
    let is_across = size.abs() > ALONG * dot(x1, x1).max(dot(x2, x2));
    is_across.then(|| scale(size.recip(), across))
}

impl RimPoint {
    /// Weight times what the ray has swept, by the functions of the face.
    pub(super) fn swept(&self) -> [f64; NODES] {
        let swept = self.site.weight * self.point.swept();
        bernstein(self.site.at).map(|value| value * swept)
    }

    /// What it adds to second derivatives of sum_j factor_j G_j.
    pub(super) fn bend(
        self,
        placed: &Placed<'_>,
        (face, piece): (usize, &Piece),
        factors: [f64; NODES],
    ) -> RimBend {
        let other = &placed.others[piece.other];
        let own = bernstein(self.site.at).into_iter().zip(factors);
        let factor: f64 = own.map(|(value, factor)| value * factor).sum();
        let [t1, t2] = self.site.along;
        let [g1, g2] = self.point.gap_slopes(other);
        let steep = self.point.swept_by_gap() * (g1 * t2 - g2 * t1) / (t1 * t1 + t2 * t2);
        let vectors = placed.vectors(face, piece).into_iter();
        let mut change: Vec<(Vector, [f64; 3])> = vectors.zip(self.point.gradient(other)).collect();
        let half = self.motion.iter();
        change.extend(half.map(|&(vector, own)| (vector, scale(0.5 * steep, own))));
        RimBend {
            change,
            motion: self.motion,
            factor: self.site.weight * factor,
        }
    }
}
