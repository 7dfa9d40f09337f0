//! The element of deformed area at a point of a face and its derivatives with respect to
//! the coefficients X_k of the deformed position x = sum N_k X_k:
//!
//! ```text
//! da = w s |a|,   a = x_,1 x x_,2,   s = 1/2 | 1 | 2 pi x_1   in space | in the plane | about the axis
//! q_k = N_k,1 x_,2 - N_k,2 x_,1,   d|a|/dX_k = r_k = q_k x e,   e = a / |a|
//! d2|a|/dX_k dX_l = (q_k . q_l I - q_l q_k^T - r_k r_l^T) / |a| - (N_k,1 N_l,2 - N_k,2 N_l,1) [e]x
//! ```
//!
//! w: weight of the rule, whose weights add up to one; in the plane x_,2 is the unit vector out
//! of it. The weight of a gap that is taken over this area makes the work of an even pressure
//! that of the volumes alone, and the multiplier a Cauchy pressure. Lengths are those of the
//! scaled body. Cost: some 100 flops a point, 60 more for each second derivative.

use std::f64::consts::TAU;

use crate::geometry::Matrix3;
use crate::geometry::vector3::{add, cross, dot, norm, scale};

/// Displacement nodes of a face at most.
pub(super) const NODES: usize = 6;

/// What an area of a face stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Extent {
    /// A triangle in space.
    #[default]
    Triangle,
    /// A segment in the plane, times a thickness of one.
    Segment,
    /// A segment, times its way around the axis x = 0.
    Ring,
}

/// da at a point, without the weight of the rule.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AreaElement {
    extent: Extent,
    /// |a|.
    length: f64,
    /// e; zero where the face has no area.
    normal: [f64; 3],
    /// q_k.
    q: [[f64; 3]; NODES],
    /// s, and for a ring its derivative by x.
    factor: [f64; 2],
}

impl AreaElement {
    /// Of the position with the coefficients `place` where the functions have `values` and
    /// `slopes`, one a node.
    pub(super) fn new(
        extent: Extent,
        place: &[[f64; 3]; NODES],
        (values, slopes): (&[f64], &[[f64; 2]]),
    ) -> Self {
        let mut along = [[0.0; 3]; 2];
        let mut radius = 0.0;
        for ((position, value), slopes) in place.iter().zip(values).zip(slopes) {
            radius += value * position[0];
            for (tangent, &slope) in along.iter_mut().zip(slopes) {
                *tangent = add(*tangent, scale(slope, *position));
            }
        }
        if extent != Extent::Triangle {
            along[1] = [0.0, 0.0, 1.0];
        }
        let area = cross(along[0], along[1]);
        let length = norm(area);
        let inverse = if length > 0.0 { length.recip() } else { 0.0 };
        let mut q = [[0.0; 3]; NODES];
        for (q, slopes) in q.iter_mut().zip(slopes) {
            *q = add(scale(slopes[0], along[1]), scale(-slopes[1], along[0]));
        }
        Self {
            extent,
            length,
            normal: scale(inverse, area),
            q,
            factor: match extent {
                Extent::Triangle => [0.5, 0.0],
                Extent::Segment => [1.0, 0.0],
                Extent::Ring => [TAU * radius, TAU],
            },
        }
    }

    /// s |a|.
    pub(super) fn size(&self) -> f64 {
        self.factor[0] * self.length
    }

    /// d(s |a|)/dX_k, where the function of the node has `value`.
    pub(super) fn gradient(&self, node: usize, value: f64) -> [f64; 3] {
        let mut gradient = scale(self.factor[0], self.stretch(node));
        gradient[0] += self.factor[1] * self.length * value;
        gradient
    }

    /// r_k.
    fn stretch(&self, node: usize) -> [f64; 3] {
        cross(self.q[node], self.normal)
    }

    /// d2(s |a|)/dX_k dX_l, where the functions of the nodes have `values` and `slopes`.
    pub(super) fn hessian(
        &self,
        [k, l]: [usize; 2],
        values: [f64; 2],
        slopes: [[f64; 2]; 2],
    ) -> Matrix3 {
        if self.length <= 0.0 {
            return [[0.0; 3]; 3];
        }
        let [of_k, of_l] = [self.stretch(k), self.stretch(l)];
        let (q_k, q_l) = (self.q[k], self.q[l]);
        let inverse = self.length.recip();
        let across = dot(q_k, q_l);
        let turn = slopes[0][0] * slopes[1][1] - slopes[0][1] * slopes[1][0];
        let skew = skew(self.normal);
        let mut out: Matrix3 = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let own = if i == j { across } else { 0.0 };
                let bend = (own - q_l[i] * q_k[j] - of_k[i] * of_l[j]) * inverse;
                self.factor[0] * (bend - turn * skew[i][j])
            })
        });
        if self.extent == Extent::Ring {
            (0..3).for_each(|j| out[0][j] += self.factor[1] * values[0] * of_l[j]);
            (0..3).for_each(|i| out[i][0] += self.factor[1] * values[1] * of_k[i]);
        }
        out
    }
}

/// The matrix of e x.
fn skew([x, y, z]: [f64; 3]) -> Matrix3 {
    [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::follower::shape_slopes;
    use crate::assembly::load::shape_values;
    use crate::linalg::vector::reproducible_noise;

    const STEP: f64 = 1e-5;

    /// The greatest errors of gradient and Hessian by central differences.
    fn errors(extent: Extent, l: &[f64]) -> [f64; 2] {
        let (values, slopes) = (shape_values(l), shape_slopes(l));
        let noise = reproducible_noise(3 * NODES);
        let mut place = [[0.0; 3]; NODES];
        let corners = [[1.0, 0.2, 0.0], [2.0, 0.9, 0.1], [1.3, 0.4, 1.2]];
        let in_plane = extent != Extent::Triangle;
        for (node, position) in place.iter_mut().enumerate().take(values.len()) {
            let first = corners.get(node).filter(|_| node < l.len());
            *position = first.copied().unwrap_or_default();
            for (i, x) in position.iter_mut().enumerate() {
                *x += 0.1 * noise[3 * node + i];
            }
            if in_plane {
                position[2] = 0.0;
            }
        }
        let at = |place: &[[f64; 3]; NODES]| AreaElement::new(extent, place, (&values, &slopes));
        let moved = |node: usize, i: usize, step: f64| {
            let mut moved = place;
            moved[node][i] += step;
            at(&moved)
        };
        let element = at(&place);
        let mut worst = [0.0_f64; 2];
        let directions = if in_plane { 2 } else { 3 };
        for l in 0..values.len() {
            for j in 0..directions {
                let [ahead, behind] = [STEP, -STEP].map(|step| moved(l, j, step));
                let slope = (ahead.size() - behind.size()) / (2.0 * STEP);
                let error = slope - element.gradient(l, values[l])[j];
                worst[0] = worst[0].max(error.abs());
                for k in 0..values.len() {
                    let hessian =
                        element.hessian([k, l], [values[k], values[l]], [slopes[k], slopes[l]]);
                    let ends = [ahead, behind].map(|end| end.gradient(k, values[k]));
                    for (i, row) in hessian.iter().enumerate().take(directions) {
                        let slope = (ends[0][i] - ends[1][i]) / (2.0 * STEP);
                        worst[1] = worst[1].max((slope - row[j]).abs());
                    }
                }
            }
        }
        worst
    }

    #[test]
    fn derivatives_of_the_area_are_those_of_differences() {
        let cases: [(Extent, &[f64]); 3] = [
            (Extent::Triangle, &[0.2, 0.5, 0.3]),
            (Extent::Segment, &[0.3, 0.7]),
            (Extent::Ring, &[0.3, 0.7]),
        ];
        for (extent, l) in cases {
            let [gradient, hessian] = errors(extent, l);
            assert!(gradient < 1e-8 && hessian < 1e-8, "{extent:?}");
        }
    }
}
