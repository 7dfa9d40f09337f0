//! A face whose edges have offsets: the true surface over a flat facet,
//!
//! ```text
//! x(l) = sum L_v x_v + sum 4 L_a L_b (c_e + o_e),   o_e = sum_v s_ev x_v + h_e nu
//! ```
//!
//! with c_e the edge unknowns of the displacement and nu the unit normal of the corners.
//! An offset stands on its facet: its tangential part is a fixed combination of the
//! corners, its height h_e goes along their normal. So it turns with a rigid motion
//! exactly, no strain stretches its height, and cells stay straight. With the surface
//! gradients g_v of the barycentric coordinates of the corners,
//!
//! ```text
//! d nu = -sum_v g_v (nu . dx_v)
//! dx = sum_k N_k du_k + sum_v (s_v - h g_v nu^T) du_v,   s_v = sum 4 L_a L_b s_ev, h alike
//! ```
//!
//! A body of linear kinematics takes nu and g_v from its undeformed corners, so that x
//! stays linear in u. Lengths are those of the scaled body. Cost: some 100 flops a face.

use std::f64::consts::TAU;

use crate::geometry::Matrix3;
use crate::geometry::vector3::{add, cross, dot, norm, normalised, scale, sub};

/// How an offset follows the displacement of its facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kinematics {
    /// To first order in the displacement.
    Linear,
    /// Exactly, for any rotation.
    Finite,
}

/// The offsets of a face.
#[derive(Clone, Debug)]
pub struct CurvedFace {
    /// Positions of the undeformed corners `[3][3]`; the third of a segment is zero.
    pub corners: [[f64; 3]; 3],
    /// Offsets of the middles of the edges (0,1), (0,2), (1,2) `[3][3]`; of a segment
    /// the first.
    pub offsets: [[f64; 3]; 3],
    /// s_ev: tangential part of each offset as a combination of the corners `[edges][3]`.
    along: [[f64; 3]; 3],
    /// h_e: part along the normal of the corners `[edges]`.
    height: [f64; 3],
    /// Normal and slopes of the undeformed facet.
    base: Facet,
    /// How the offsets follow the facet.
    pub kinematics: Kinematics,
}

/// The plane of some corners.
#[derive(Clone, Copy, Debug, Default)]
struct Facet {
    /// Unit normal, to the side that the order of the corners gives.
    normal: [f64; 3],
    /// Gradients of the barycentric coordinates along the facet `[corners][3]`.
    gradients: [[f64; 3]; 3],
}

impl Facet {
    /// Of the first `count` of `corners`, which are not degenerate.
    fn of(corners: &[[f64; 3]; 3], count: usize) -> Self {
        let [a, b, c] = *corners;
        let first = sub(b, a);
        if count == 2 {
            let slope = scale(1.0 / dot(first, first), first);
            return Self {
                normal: scale(1.0 / norm(first), [first[1], -first[0], 0.0]),
                gradients: [scale(-1.0, slope), slope, [0.0; 3]],
            };
        }
        let second = sub(c, a);
        let area = cross(first, second);
        let normal = normalised(area).unwrap_or_default();
        let shrink = 1.0 / norm(area);
        let [to_b, to_c] = [cross(second, normal), cross(normal, first)];
        let [to_b, to_c] = [scale(shrink, to_b), scale(shrink, to_c)];
        Self {
            normal,
            gradients: [scale(-1.0, add(to_b, to_c)), to_b, to_c],
        }
    }
}

impl CurvedFace {
    /// Of a face with `count` corners.
    pub fn new(
        count: usize,
        corners: [[f64; 3]; 3],
        offsets: [[f64; 3]; 3],
        kinematics: Kinematics,
    ) -> Self {
        let base = Facet::of(&corners, count);
        Self {
            along: offsets.map(|offset| base.gradients.map(|gradient| dot(gradient, offset))),
            height: offsets.map(|offset| dot(base.normal, offset)),
            corners,
            offsets,
            base,
            kinematics,
        }
    }

    /// Undeformed position at the barycentric coordinates `l` `[corners]`.
    pub fn position(&self, l: &[f64]) -> [f64; 3] {
        let mut position = [0.0; 3];
        for (corner, l) in self.corners.iter().zip(l) {
            position = add(position, scale(*l, *corner));
        }
        for (offset, value) in self.offsets.iter().zip(edge_values(l)) {
            position = add(position, scale(value, *offset));
        }
        position
    }

    /// Area (length in 2D) per weight of a rule at `l`, undeformed, without any turn.
    fn flat_area_at(&self, l: &[f64]) -> f64 {
        let [a, b, c] = self.corners;
        let mut along = [sub(b, a), sub(c, a)];
        for (tangent, slopes) in along.iter_mut().zip(edge_slopes(l)) {
            for (offset, slope) in self.offsets.iter().zip(slopes) {
                *tangent = add(*tangent, scale(slope, *offset));
            }
        }
        match l.len() {
            2 => norm(along[0]),
            _ => 0.5 * norm(cross(along[0], along[1])),
        }
    }

    /// Area per weight of a rule at `l`; `is_turned` about the axis x = 0.
    pub(super) fn area_at(&self, l: &[f64], is_turned: bool) -> f64 {
        let flat = self.flat_area_at(l);
        match is_turned {
            true => flat * TAU * self.position(l)[0],
            false => flat,
        }
    }

    /// The offsets on displaced corners; `moved` are the displacements of the corners
    /// `[3][3]`.
    pub(super) fn deformed(&self, count: usize, moved: &[[f64; 3]; 3]) -> Standing {
        let now: [[f64; 3]; 3] = std::array::from_fn(|v| add(self.corners[v], moved[v]));
        let facet = match self.kinematics {
            Kinematics::Linear => self.base,
            Kinematics::Finite => Facet::of(&now, count),
        };
        Standing {
            offsets: std::array::from_fn(|edge| match self.kinematics {
                Kinematics::Linear => add(self.offsets[edge], self.change(edge, moved)),
                Kinematics::Finite => {
                    let tangential = combined(&self.along[edge], &now);
                    add(tangential, scale(self.height[edge], facet.normal))
                }
            }),
            along: self.along,
            height: self.height,
            facet,
            count,
        }
    }

    /// To first order, the change of an offset.
    fn change(&self, edge: usize, moved: &[[f64; 3]; 3]) -> [f64; 3] {
        let mut change = combined(&self.along[edge], moved);
        for (gradient, moved) in self.base.gradients.iter().zip(moved) {
            let rise = self.height[edge] * dot(self.base.normal, *moved);
            change = sub(change, scale(rise, *gradient));
        }
        change
    }
}

/// The sum of `vectors` with those factors.
fn combined(factors: &[f64; 3], vectors: &[[f64; 3]; 3]) -> [f64; 3] {
    let terms = factors.iter().zip(vectors);
    terms.fold([0.0; 3], |sum, (factor, vector)| {
        add(sum, scale(*factor, *vector))
    })
}

/// 4 L_a L_b of the edges (0,1), (0,2), (1,2).
fn edge_values(l: &[f64]) -> [f64; 3] {
    match *l {
        [a, b, c] => [4.0 * a * b, 4.0 * a * c, 4.0 * b * c],
        [a, b] => [4.0 * a * b, 0.0, 0.0],
        _ => [0.0; 3],
    }
}

/// Derivatives of [`edge_values`] along l_1 and l_2.
fn edge_slopes(l: &[f64]) -> [[f64; 3]; 2] {
    match *l {
        [a, b, c] => [
            [4.0 * (a - b), -4.0 * c, 4.0 * c],
            [-4.0 * b, 4.0 * (a - c), 4.0 * b],
        ],
        [a, b] => [[4.0 * (a - b), 0.0, 0.0], [0.0; 3]],
        _ => [[0.0; 3]; 2],
    }
}

/// A curved face on its displaced corners: where its offsets are, and how its points
/// move with the nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standing {
    /// Offsets of the edges `[3][3]`.
    pub(super) offsets: [[f64; 3]; 3],
    along: [[f64; 3]; 3],
    height: [f64; 3],
    facet: Facet,
    /// Corners of the face.
    count: usize,
}

impl Standing {
    /// The part at each corner of what an offset would gain along `direction`:
    /// (do_e/du_v)^T `direction` `[corners]`.
    fn pull(&self, edge: usize, direction: [f64; 3]) -> [[f64; 3]; 3] {
        std::array::from_fn(|v| {
            let tilt = self.height[edge] * dot(direction, self.facet.gradients[v]);
            let straight = scale(self.along[edge][v], direction);
            sub(straight, scale(tilt, self.facet.normal))
        })
    }

    /// Turns derivatives by the coefficients of the position into those by the displacement,
    /// `[3, nodes]`.
    pub(super) fn pull_row(&self, row: &mut [f64]) {
        let (count, nodes) = (self.count, row.len() / 3);
        for edge in 0..nodes - count {
            let own = std::array::from_fn(|i| row[i * nodes + count + edge]);
            for (v, part) in self.pull(edge, own).iter().enumerate().take(count) {
                (0..3).for_each(|i| row[i * nodes + v] += part[i]);
            }
        }
    }

    /// Turns second derivatives by the coefficients of the position into those by the
    /// displacement, `[nodes, nodes, 3, 3]`; `gradient` `[nodes]` are the first ones, along
    /// which the turning of the offsets acts.
    pub(super) fn pull_blocks(&self, gradient: &[[f64; 3]; 6], blocks: &mut [f64]) {
        let count = self.count;
        let nodes = count * (count + 1) / 2;
        let at = |k: usize, l: usize| 9 * (k * nodes + l);
        // Rows, then columns, of the edges onto the corners.
        for edge in 0..nodes - count {
            for other in 0..nodes {
                for j in 0..3 {
                    let from = at(count + edge, other) + j;
                    let own = [blocks[from], blocks[from + 3], blocks[from + 6]];
                    for (v, part) in self.pull(edge, own).iter().enumerate().take(count) {
                        (0..3).for_each(|i| blocks[at(v, other) + 3 * i + j] += part[i]);
                    }
                }
            }
        }
        for edge in 0..nodes - count {
            for other in 0..nodes {
                for i in 0..3 {
                    let from = at(other, count + edge) + 3 * i;
                    let own = [blocks[from], blocks[from + 1], blocks[from + 2]];
                    for (v, part) in self.pull(edge, own).iter().enumerate().take(count) {
                        (0..3).for_each(|j| blocks[at(other, v) + 3 * i + j] += part[j]);
                    }
                }
            }
        }
        for v in 0..count {
            for w in 0..count {
                let mut turning = [[0.0; 3]; 3];
                for edge in 0..nodes - count {
                    self.add_turning([v, w], (edge, gradient[count + edge]), &mut turning);
                }
                let block = blocks[at(v, w)..].iter_mut();
                block
                    .zip(turning.as_flattened())
                    .for_each(|(entry, part)| *entry += part);
            }
        }
    }

    /// The second derivative of an offset along `direction`: its height times that of nu.
    fn add_turning(
        &self,
        [v, w]: [usize; 2],
        (edge, direction): (usize, [f64; 3]),
        out: &mut Matrix3,
    ) {
        let (nu, [of_v, of_w]) = (
            self.facet.normal,
            [v, w].map(|corner| self.facet.gradients[corner]),
        );
        let height = self.height[edge];
        let [by_v, by_w] = [of_v, of_w].map(|gradient| height * dot(direction, gradient));
        let bend = height * dot(direction, nu) * dot(of_v, of_w);
        for (i, row) in out.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry += by_w * nu[i] * of_v[j] + by_v * of_w[i] * nu[j] - bend * nu[i] * nu[j];
            }
        }
    }

    /// The point with those values of the hierarchical functions, of `count` corners.
    pub(super) fn at<'a>(&'a self, shapes: &'a [f64], count: usize) -> StandingPoint<'a> {
        let (mut along, mut height) = ([0.0; 3], 0.0);
        for (edge, value) in shapes[count..].iter().enumerate() {
            height += value * self.height[edge];
            for (sum, part) in along.iter_mut().zip(self.along[edge]) {
                *sum += value * part;
            }
        }
        StandingPoint {
            shapes,
            count,
            along,
            height,
            facet: &self.facet,
        }
    }
}

/// dx/du at a point of a curved face.
pub(super) struct StandingPoint<'a> {
    /// Values of the hierarchical functions of the face `[nodes]`.
    shapes: &'a [f64],
    /// Corners of the face.
    count: usize,
    /// s_v at the point.
    along: [f64; 3],
    /// h at the point.
    height: f64,
    facet: &'a Facet,
}

impl StandingPoint<'_> {
    /// (dx/du_k)^T `direction`: how far the point goes along it with node `k`.
    pub(super) fn pulled(&self, k: usize, direction: [f64; 3]) -> [f64; 3] {
        let own = self.shapes[k];
        if k >= self.count {
            return scale(own, direction);
        }
        let tilt = self.height * dot(direction, self.facet.gradients[k]);
        let straight = scale(own + self.along[k], direction);
        sub(straight, scale(tilt, self.facet.normal))
    }

    /// The Hessian of d(x(u)) by the nodes `v` and `w` of a body of linear kinematics, from
    /// that of d: both points moved.
    pub(super) fn hessian(&self, [v, w]: [usize; 2], own: &Matrix3) -> Matrix3 {
        // Rows (dx/du_v)^T H, then each against dx/du_w.
        let columns: [[f64; 3]; 3] =
            std::array::from_fn(|j| self.pulled(v, [own[0][j], own[1][j], own[2][j]]));
        std::array::from_fn(|i| self.pulled(w, [columns[0][i], columns[1][i], columns[2][i]]))
    }
}

#[cfg(test)]
mod tests;
