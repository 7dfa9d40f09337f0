//! The nearest point of a patch to a point in space: Newton's method for
//! |x - X(l)|^2 / 2 over the triangle, along its edges where it leads out of it.

use super::patch::Patch;
use crate::geometry::vector3::{dot, norm, sub};

/// Steps at most.
const STEPS: usize = 20;
/// Change of a coordinate at which a search has ended.
const END: f64 = 1e-14;
/// The same of a method that squares what is left.
const NEAR_END: f64 = 1e-8;
/// Largest change of a coordinate that leads anywhere.
const FARTHEST: f64 = 10.0;

/// Where the nearest point of a patch lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Part {
    Inside,
    /// On the edge opposite a corner.
    Edge(usize),
    Corner(usize),
}

/// Nearest point of one patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    pub(super) l: [f64; 3],
    pub(super) part: Part,
    /// From it to the point.
    pub(super) offset: [f64; 3],
    pub(super) distance: f64,
}

/// Where Newton's method ends.
pub(super) enum Search {
    Inside(Foot),
    /// Outside the triangle, at these coordinates.
    Beyond([f64; 3]),
    /// Nowhere.
    Lost,
}

impl Patch {
    /// The nearest point to `x`, the search beginning at `start`.
    pub(super) fn closest(&self, x: [f64; 3], start: [f64; 3]) -> Foot {
        match self.search(x, start) {
            Search::Inside(foot) => foot,
            Search::Beyond(_) | Search::Lost => self.on_boundary(x),
        }
    }

    fn foot(&self, x: [f64; 3], l: [f64; 3], part: Part) -> Foot {
        let offset = sub(x, self.point(l));
        Foot {
            l,
            part,
            offset,
            distance: norm(offset),
        }
    }

    /// Newton's method from `start`.
    pub(super) fn search(&self, x: [f64; 3], start: [f64; 3]) -> Search {
        let mut at = [start[1], start[2]];
        for _ in 0..STEPS {
            let Some((step, is_convex)) = self.step(x, at) else {
                return Search::Lost;
            };
            at = [at[0] + step[0], at[1] + step[1]];
            let size = step[0].abs().max(step[1].abs());
            // Newton's method squares what is left.
            if size < END || (is_convex && size < NEAR_END) {
                break;
            }
        }
        let l = [1.0 - at[0] - at[1], at[0], at[1]];
        if l.iter().all(|l| *l >= 0.0) {
            Search::Inside(self.foot(x, l, Part::Inside))
        } else {
            Search::Beyond(l)
        }
    }

    /// A step of the method, and whether it is one with second derivatives; none where it leads
    /// far away.
    fn step(&self, x: [f64; 3], at: [f64; 2]) -> Option<([f64; 2], bool)> {
        let d = self.derivatives([1.0 - at[0] - at[1], at[0], at[1]]);
        let offset = sub(x, d.point);
        let slope = d.first.map(|tangent| dot(offset, tangent));
        let metric = [
            dot(d.first[0], d.first[0]),
            dot(d.first[0], d.first[1]),
            dot(d.first[1], d.first[1]),
        ];
        let bent: [f64; 3] = std::array::from_fn(|i| metric[i] - dot(offset, d.second[i]));
        let determinant = |m: [f64; 3]| m[0] * m[2] - m[1] * m[1];
        // Far on the hollow side the distance has a saddle: the metric leads down.
        let is_convex = bent[0] > 0.0 && determinant(bent) > 0.1 * determinant(metric);
        let matrix = if is_convex { bent } else { metric };
        let whole = determinant(matrix);
        let step = [
            (matrix[2] * slope[0] - matrix[1] * slope[1]) / whole,
            (matrix[0] * slope[1] - matrix[1] * slope[0]) / whole,
        ];
        let size = step[0].abs().max(step[1].abs());
        (size <= FARTHEST).then_some((step, is_convex))
    }

    fn on_boundary(&self, x: [f64; 3]) -> Foot {
        let feet = [0, 1, 2].map(|opposite| self.on_edge(x, opposite));
        let [first, second, third] = feet;
        let nearer = |a: Foot, b: Foot| if b.distance < a.distance { b } else { a };
        nearer(nearer(first, second), third)
    }

    /// Nearest point of the edge opposite a corner: the least of a polynomial of degree four,
    /// by Newton's method from its flat nearest point.
    fn on_edge(&self, x: [f64; 3], opposite: usize) -> Foot {
        let (from, to) = ((opposite + 1) % 3, (opposite + 2) % 3);
        let (a, b) = (self.corners[from], self.corners[to]);
        let along = sub(b, a);
        let c = self.bends[opposite];
        let mut t = (dot(sub(x, a), along) / dot(along, along)).clamp(0.0, 1.0);
        for _ in 0..STEPS {
            let tangent: [f64; 3] = std::array::from_fn(|i| along[i] - (1.0 - 2.0 * t) * c[i]);
            let offset: [f64; 3] =
                std::array::from_fn(|i| x[i] - a[i] - t * along[i] + t * (1.0 - t) * c[i]);
            let slope = dot(offset, tangent);
            let metric = dot(tangent, tangent);
            let bent = metric - 2.0 * dot(offset, c);
            let next = t + slope / if bent > 0.1 * metric { bent } else { metric };
            let next = if next.is_finite() {
                next.clamp(0.0, 1.0)
            } else {
                t
            };
            let change = (next - t).abs();
            t = next;
            if change < END {
                break;
            }
        }
        let mut l = [0.0; 3];
        l[from] = 1.0 - t;
        l[to] = t;
        let part = match t {
            0.0 => Part::Corner(from),
            1.0 => Part::Corner(to),
            _ => Part::Edge(opposite),
        };
        self.foot(x, l, part)
    }
}
