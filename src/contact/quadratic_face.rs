//! A deformed face as a quadratic map of barycentric coordinates:
//!
//! ```text
//! x(l) = sum l_a c_a + sum 4 l_a l_b e_ab,   x(m + s (l - m)) of the same form: c'_a = x(m + s (d_a - m)), e' = s^2 e
//! ```
//!
//! c deformed corners `[3][3]`, e the corrections at edges (0,1), (0,2), (1,2) `[3][3]`, those of
//! the displacement and of a curved face together. A part of the face is a face again, so that
//! one lattice of points serves all parts. Lengths are those of the scaled body. Cost: 36
//! products a point.

use super::deformed::Deformed;
use super::face::ContactFace;
use crate::geometry::vector3::{norm, sub};

/// Ends of the edges of a face.
const EDGES: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];

/// A deformed face, or a part of one; in the plane the third corner and its edges are zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadraticFace {
    corners: [[f64; 3]; 3],
    edges: [[f64; 3]; 3],
    /// Corners: 3 in space, 2 in the plane.
    count: usize,
}

impl QuadraticFace {
    /// `face` of `body`.
    pub(crate) fn of(body: &Deformed<'_>, face: &ContactFace) -> Self {
        let count = face.corners.len();
        let moved = |node: u32| -> [f64; 3] {
            let first = node as usize * body.space.components;
            let own = &body.displacement[first..first + body.space.components];
            std::array::from_fn(|i| own.get(i).copied().unwrap_or(0.0))
        };
        let (mut corners, mut edges) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for (corner, &vertex) in corners.iter_mut().zip(&face.corners) {
            let (rest, moved) = (body.mesh.coordinates()[vertex as usize], moved(vertex));
            *corner = std::array::from_fn(|i| body.scale * rest[i] + moved[i]);
        }
        for (edge, &node) in edges.iter_mut().zip(&face.nodes[count..]) {
            *edge = moved(node);
        }
        for (edge, offset) in
            (edges.iter_mut()).zip(face.curve.iter().flat_map(|curve| curve.offsets))
        {
            (0..3).for_each(|i| edge[i] += offset[i]);
        }
        Self {
            corners,
            edges,
            count,
        }
    }

    /// The point with barycentric coordinates `l`.
    pub(crate) fn at(&self, l: &[f64; 3]) -> [f64; 3] {
        let mut place = [0.0; 3];
        for (corner, share) in self.corners.iter().zip(l) {
            (0..3).for_each(|i| place[i] += share * corner[i]);
        }
        for (edge, [a, b]) in self.edges.iter().zip(EDGES) {
            let share = 4.0 * l[a] * l[b];
            (0..3).for_each(|i| place[i] += share * edge[i]);
        }
        place
    }

    /// The part that is the face shrunk to `size` towards its point `middle`.
    pub(crate) fn around(&self, middle: &[f64; 3], size: f64) -> Self {
        let mut corners = [[0.0; 3]; 3];
        for (a, corner) in corners.iter_mut().enumerate().take(self.count) {
            let own = std::array::from_fn(|b| if a == b { 1.0 } else { 0.0 });
            *corner = self.at(&towards(middle, size, &own));
        }
        Self {
            corners,
            edges: self.edges.map(|edge| edge.map(|x| size * size * x)),
            count: self.count,
        }
    }

    /// A distance that no point of the face is farther from `point` than: that of the farthest
    /// control point of its quadratic patch.
    pub(crate) fn reach(&self, point: [f64; 3]) -> f64 {
        let corners = self.corners[..self.count].iter();
        let mut reach = corners.map(|&c| norm(sub(c, point))).fold(0.0, f64::max);
        let edges = self.edges.iter().zip(EDGES);
        for (edge, [a, b]) in edges.filter(|(_, [_, b])| *b < self.count) {
            let control = std::array::from_fn(|i| {
                0.5 * (self.corners[a][i] + self.corners[b][i]) + 2.0 * edge[i]
            });
            reach = reach.max(norm(sub(control, point)));
        }
        reach
    }
}

/// The coordinates `l` shrunk to `size` towards `middle`.
pub(crate) fn towards(middle: &[f64; 3], size: f64, l: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| middle[i] + size * (l[i] - middle[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face() -> QuadraticFace {
        QuadraticFace {
            corners: [[0.1, 0.0, 0.2], [1.0, -0.1, 0.0], [0.3, 0.9, -0.2]],
            edges: [[0.05, 0.1, -0.2], [-0.1, 0.03, 0.1], [0.2, 0.0, 0.07]],
            count: 3,
        }
    }

    #[test]
    fn a_part_of_a_face_has_the_points_of_the_face() {
        let middle = [0.2, 0.5, 0.3];
        let part = face().around(&middle, 0.25);
        for l in [[0.3, 0.3, 0.4], [1.0, 0.0, 0.0], [0.0, 0.5, 0.5]] {
            let apart = sub(part.at(&l), face().at(&towards(&middle, 0.25, &l)));
            assert!(norm(apart) < 1e-15, "{apart:?}");
        }
    }

    #[test]
    fn no_point_of_a_face_is_beyond_its_reach() {
        let from = [0.4, 0.3, 0.1];
        let reach = face().reach(from);
        let steps = 0..=20;
        let points = steps.flat_map(|i| (0..=20 - i).map(move |j| [i, j, 20 - i - j]));
        let points = points.map(|l| l.map(|x| f64::from(x) / 20.0));
        let farthest = points.map(|l| norm(sub(face().at(&l), from)));
        let farthest = farthest.fold(0.0, f64::max);
        assert!(
            farthest <= reach && reach < 1.5 * farthest,
            "{farthest} {reach}"
        );
    }
}
