//! How far a face has slid along the other surface since the increment began, and what tractions do,
//! at points of its pieces:
//!
//! ```text
//! P = 1 - n n' / (n.n),   e = dx + g dn - dy
//! V_j = int psi_j P0 [ y0(l') - x0(l) ] da     what is met now, as the face saw it at the start
//! W_j = int psi_j P e da                       d of P (x - y) with l and l' held
//! d(sum T_j.W_j) = int [ dt c + t dc ] da + t c d(da),   t = P sum psi_j T_j
//! ```
//!
//! l' the place that the ray from l meets now, c the factors of the vectors in e. P (x - y) is zero on a
//! ray, so that its derivative is across n whatever P does: tractions push both surfaces at the ends of
//! a ray, and what is left of a moment turns the normal. T_j are vectors along tangents
//! ([`super::frames`]). Faces that meet have common slips and common factors on their borders, which add
//! nothing but at rims. Shapes: by function, and by the fifteen vectors of [`super::point`]; lengths of
//! the caller, V_j volumes. Cost: some 2e3 flops a point, 1e4 for the change of forces.

use super::bends::{FaceBend, Part};
use super::choice::Piece;
use super::normals::Vector;
use super::pair::{Meeting, Placed};
use super::patch::{self, NODES, Patch, bernstein};
use super::point::{Bend, Block, OTHER, Point, VECTORS, add_times, outer};
use super::rays::Rayed;
use crate::geometry::vector3::{add, cross, dot, norm, scale, sub};

/// Of each function of a face a vector by the fifteen vectors.
pub(super) type Blocks = [[Block; VECTORS]; NODES];

/// Two surfaces where they were.
pub(super) struct Before {
    /// Faces of the carrier.
    pub(super) own: Vec<Rayed>,
    /// Faces of the other surface.
    pub(super) others: Vec<Patch>,
}

/// v without its part along n.
fn across(v: [f64; 3], n: [f64; 3]) -> [f64; 3] {
    sub(v, scale(dot(n, v) / dot(n, n), n))
}

/// P.
fn projection(n: [f64; 3]) -> Block {
    let unit = [0, 1, 2].map(|i: usize| [0, 1, 2].map(|j: usize| f64::from(u8::from(i == j))));
    unit.map(|axis| across(axis, n))
}

/// The matrix of d(P T) by n.
fn turning(n: [f64; 3], vector: [f64; 3]) -> Block {
    let square = dot(n, n);
    let along = dot(n, vector) / square;
    let mut rows = outer(
        n,
        sub(scale(2.0 * along / square, n), scale(1.0 / square, vector)),
    );
    (0..3).for_each(|i| rows[i][i] -= along);
    rows
}

impl Before {
    /// P0 (y0 - x0) of what a point meets now.
    pub(super) fn slid(&self, [face, other]: [usize; 2], point: &Point) -> [f64; 3] {
        let own = &self.own[face];
        let met = self.others[other].point(point.met.at);
        across(sub(met, own.patch.point(point.at)), own.normal(point.at))
    }
}

impl Point {
    /// c of all vectors.
    fn shares(&self) -> [f64; VECTORS] {
        self.factors().map(|forms| forms[0])
    }

    /// Derivative of |x_,1 x x_,2| by x_,1 and x_,2.
    fn area_slopes(&self) -> [[f64; 3]; 2] {
        let [x1, x2] = self.tangents();
        let across = cross(x1, x2);
        let unit = scale(norm(across).recip(), across);
        [cross(x2, unit), cross(unit, x1)]
    }

    /// Derivative of |x_,1 x x_,2| by the nodes of the face.
    fn area_gradient(&self) -> [[f64; 3]; NODES] {
        let [first, second] = self.area_slopes();
        let slopes = patch::slopes(self.at);
        std::array::from_fn(|k| add(scale(slopes[0][k], first), scale(slopes[1][k], second)))
    }

    /// m_1 and m_2: dl' = m.e.
    fn carried_along(&self, other: &Patch) -> [[f64; 3]; 2] {
        let n = self.normal();
        let (_, c) = self.across(other);
        let [y1, y2] = other.tangents(self.met.at);
        [cross(y2, n), cross(n, y1)].map(|v| scale(c.recip(), v))
    }

    /// Derivative of c of a vector by e.
    fn share_slope(&self, vector: usize, (down, along): ([f64; 3], [[f64; 3]; 2])) -> [f64; 3] {
        match vector {
            0..NODES => [0.0; 3],
            NODES..OTHER => {
                let [s, t] = self.at;
                scale([1.0 - s - t, s, t][vector - NODES], down)
            }
            _ => {
                let slopes = patch::slopes(self.met.at);
                let [first, second] = slopes.map(|own| -own[vector - OTHER]);
                add(scale(first, along[0]), scale(second, along[1]))
            }
        }
    }

    /// Adds the change of the force of `sum` = sum psi_j T_j, times `weight` without the area.
    fn add_pull_bend(&self, other: &Patch, (sum, weight): ([f64; 3], f64), out: &mut Bend) {
        let n = self.normal();
        let traction = across(sum, n);
        let shares = self.shares();
        let area = self.area();
        let turned = turning(n, sum);
        let by_ray = (self.across(other).0, self.carried_along(other));
        let stretch = self.area_gradient();
        let [s, t] = self.at;
        let hats = [1.0 - s - t, s, t];
        for (vector, row) in out.iter_mut().enumerate() {
            let slope = scale(area, self.share_slope(vector, by_ray));
            for (k, block) in row.iter_mut().enumerate() {
                let mut by = scale(shares[k], slope);
                if k < NODES {
                    by = add(by, scale(shares[vector], stretch[k]));
                }
                add_times(block, weight, &outer(traction, by));
                if (NODES..OTHER).contains(&k) {
                    let factor = weight * area * shares[vector] * hats[k - NODES];
                    add_times(block, factor, &turned);
                }
            }
        }
    }
}

impl Placed<'_> {
    /// V of a meeting.
    pub(super) fn slid(&self, meeting: &Meeting, before: &Before) -> [[f64; 3]; NODES] {
        let mut sums = [[0.0; 3]; NODES];
        for piece in &meeting.pieces {
            self.each_point((meeting.face, piece), &mut |point, weight| {
                let slid = before.slid([meeting.face, piece.other], point);
                let slid = scale(weight * point.area(), slid);
                for (sum, value) in sums.iter_mut().zip(bernstein(point.at)) {
                    *sum = add(*sum, scale(value, slid));
                }
            });
        }
        sums
    }

    /// dV on a piece, all but what moves beyond rims.
    pub(super) fn slid_slopes(
        &self,
        (face, piece): (usize, &Piece),
        before: &Before,
    ) -> Box<Blocks> {
        let other = &self.others[piece.other];
        let was = (&before.own[face], &before.others[piece.other]);
        self.blocks((face, piece), &|point| {
            let normal = was.0.normal(point.at);
            let slid = before.slid([face, piece.other], point);
            let met = was.1.tangents(point.met.at).map(|y| across(y, normal));
            let along = point.carried_along(other);
            let carried = sum(outer(met[0], along[0]), outer(met[1], along[1]));
            let (shares, stretch) = (point.shares(), point.area_gradient());
            let mut rows = [Block::default(); VECTORS];
            for (k, row) in rows.iter_mut().enumerate() {
                add_times(row, shares[k] * point.area(), &carried);
                if k < NODES {
                    add_times(row, 1.0, &outer(slid, stretch[k]));
                }
            }
            rows
        })
    }

    /// W on a piece.
    pub(super) fn pulls(&self, piece: (usize, &Piece)) -> Box<Blocks> {
        self.blocks(piece, &|point| {
            let across = projection(point.normal());
            point.shares().map(|share| {
                let mut row = Block::default();
                add_times(&mut row, share * point.area(), &across);
                row
            })
        })
    }

    /// W on a piece of linear bodies: across the other surface, with normals that stay.
    pub(super) fn pulls_at_rest(&self, piece: (usize, &Piece)) -> Box<Blocks> {
        let other = &self.others[piece.1.other];
        self.blocks(piece, &|point| {
            let across = projection(other.area_vector(point.met.at));
            let mut shares = point.shares();
            shares[NODES..OTHER].fill(0.0);
            shares.map(|share| {
                let mut row = Block::default();
                add_times(&mut row, share * point.area(), &across);
                row
            })
        })
    }

    /// int psi_j of what `at` has at a point.
    fn blocks(
        &self,
        piece: (usize, &Piece),
        at: &dyn Fn(&Point) -> [Block; VECTORS],
    ) -> Box<Blocks> {
        let mut sums: Box<Blocks> = Box::new([[Block::default(); VECTORS]; NODES]);
        self.each_point(piece, &mut |point, weight| {
            let own = at(point);
            for (sums, value) in sums.iter_mut().zip(bernstein(point.at)) {
                for (sum, own) in sums.iter_mut().zip(&own) {
                    add_times(sum, weight * value, own);
                }
            }
        });
        sums
    }

    /// Change of the forces of tractions T_j of a part of a face.
    pub(super) fn pull_bend(&self, part: &Part<'_>, tractions: &[[f64; 3]; NODES]) -> FaceBend {
        let face = part.meeting.face;
        let pieces = part.pieces();
        let rims = pieces.iter().flat_map(|piece| {
            let points = self.rim_points(face, piece).into_iter();
            points.map(|point| point.pull(self, (face, piece), tractions))
        });
        let rims: Vec<_> = rims.collect();
        let of_pieces = pieces.iter().flat_map(|piece| self.vectors(face, piece));
        let of_rims = rims.iter().flat_map(|rim| &rim.motion);
        let of_rims = of_rims.map(|(vector, _)| *vector);
        let mut bend = FaceBend::of(of_pieces.chain(of_rims).collect());
        for piece in pieces {
            let own = self.pull_bend_of((face, piece), tractions, &mut bend.by_normals);
            bend.add_piece(&self.vectors(face, piece), &own);
        }
        for rim in &rims {
            bend.add_product(rim.factor, [&rim.force, &rim.motion]);
        }
        bend
    }

    /// The same on a piece; adds the force by its normals.
    fn pull_bend_of(
        &self,
        (face, piece): (usize, &Piece),
        tractions: &[[f64; 3]; NODES],
        by_normals: &mut [[f64; 3]; 3],
    ) -> Box<Bend> {
        let mut sums: Box<Bend> = Box::new([[Block::default(); VECTORS]; VECTORS]);
        let other = &self.others[piece.other];
        self.each_point((face, piece), &mut |point, weight| {
            let sum = at_point(point, tractions);
            point.add_pull_bend(other, (sum, weight), &mut sums);
            let traction = scale(weight * point.area(), across(sum, point.normal()));
            let shares = &point.shares()[NODES..OTHER];
            for (sum, share) in by_normals.iter_mut().zip(shares) {
                *sum = add(*sum, scale(*share, traction));
            }
        });
        sums
    }
}

/// sum psi_j T_j.
fn at_point(point: &Point, tractions: &[[f64; 3]; NODES]) -> [f64; 3] {
    let values = bernstein(point.at).into_iter().zip(tractions);
    values.fold([0.0; 3], |sum, (value, own)| add(sum, scale(value, *own)))
}

fn sum(a: Block, b: Block) -> Block {
    [0, 1, 2].map(|i| add(a[i], b[i]))
}

/// The force of tractions at a point of a line beyond a rim, by vectors.
pub(super) fn pull_at(
    point: &Point,
    vectors: [Vector; VECTORS],
    tractions: &[[f64; 3]; NODES],
) -> Vec<(Vector, [f64; 3])> {
    let pull = across(at_point(point, tractions), point.normal());
    let pull = scale(point.area(), pull);
    let shares = vectors.into_iter().zip(point.shares());
    shares
        .map(|(vector, share)| (vector, scale(share, pull)))
        .collect()
}
