//! One patch: X(l) = sum_i l_i x_i - sum_(i<j) l_i l_j c_ij over the barycentric coordinates l.
//!
//! c_ij is the least vector that makes the edge from x_i to x_j orthogonal to the normals at its
//! ends: with d = x_j - x_i, m and k half the sum and half the difference n_i - n_j of the
//! normals,
//!
//! ```text
//! c = (k . d) / |m|^2 m + (m . d) / |k|^2 k
//! ```
//!
//! The second part, that of an S, is left out where normals are so alike that it would be noise,
//! and the whole where it bends by more than half the edge, or by more than the normals at its
//! ends turn away from it: the edge is a line then.

use crate::geometry::vector3::{add, cross, dot, norm, scale, sub};

/// |k|^2 below which an S is noise.
const ALIKE: f64 = 1e-8;
/// Largest |c| over |d|.
const MOST_BENT: f64 = 0.5;

/// A patch over one facet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    pub(super) corners: [[f64; 3]; 3],
    /// c of the edge opposite each corner.
    pub(super) bends: [[f64; 3]; 3],
}

/// c of the edge between two corners with their normals.
pub(super) fn bend([a, b]: [[f64; 3]; 2], [at_a, at_b]: [[f64; 3]; 2]) -> [f64; 3] {
    let along = sub(b, a);
    let mean = scale(0.5, add(at_a, at_b));
    let half = scale(0.5, sub(at_a, at_b));
    let arch = scale(dot(half, along) / dot(mean, mean).max(ALIKE), mean);
    let inflection = if dot(half, half) > ALIKE {
        scale(dot(mean, along) / dot(half, half), half)
    } else {
        [0.0; 3]
    };
    let turned = dot(at_a, along).abs() + dot(at_b, along).abs();
    let most = turned.min(MOST_BENT * norm(along));
    let is_small = |c: [f64; 3]| norm(c) <= most;
    [add(arch, inflection), arch]
        .into_iter()
        .find(|c| is_small(*c))
        .unwrap_or_default()
}

/// Point, first and second derivatives along the first two coordinates after l_0.
pub(super) struct Derivatives {
    pub(super) point: [f64; 3],
    /// dX/dl_1 and dX/dl_2, l_0 following.
    pub(super) first: [[f64; 3]; 2],
    /// Second derivatives 11, 12, 22.
    pub(super) second: [[f64; 3]; 3],
}

impl Patch {
    /// The point at barycentric coordinates `l`.
    pub(super) fn point(&self, l: [f64; 3]) -> [f64; 3] {
        let mut point = [0.0; 3];
        for k in 0..3 {
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            point = add(point, scale(l[k], self.corners[k]));
            point = sub(point, scale(l[a] * l[b], self.bends[k]));
        }
        point
    }

    pub(super) fn derivatives(&self, l: [f64; 3]) -> Derivatives {
        // dX/dl_i with all coordinates free.
        let free = |i: usize| {
            let (a, b) = ((i + 1) % 3, (i + 2) % 3);
            // l_i l_a belongs to the edge opposite b.
            let bent = add(scale(l[a], self.bends[b]), scale(l[b], self.bends[a]));
            sub(self.corners[i], bent)
        };
        let [zero, one, two] = [0, 1, 2].map(free);
        let [c12, c20, c01] = self.bends;
        // d2X/dl_i dl_j = -c_ij with all free; l_0 = 1 - l_1 - l_2.
        let mixed = sub(add(c01, c20), c12);
        Derivatives {
            point: self.point(l),
            first: [sub(one, zero), sub(two, zero)],
            second: [scale(2.0, c01), mixed, scale(2.0, c20)],
        }
    }

    /// Unit normal at `l`, to the side that sees the corners anticlockwise.
    pub(super) fn normal(&self, l: [f64; 3]) -> [f64; 3] {
        let [first, second] = self.derivatives(l).first;
        let normal = cross(first, second);
        scale(1.0 / norm(normal).max(f64::MIN_POSITIVE), normal)
    }
}
