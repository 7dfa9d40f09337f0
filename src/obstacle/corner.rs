//! Distances to a convex corner rounded by a radius r, of `N` faces that are orthogonal to
//! each other:
//!
//! ```text
//! d(q) = |max(q, 0)| - r  where some q_i > 0,   max_i q_i - r  elsewhere
//! ```
//!
//! q_i being the distances from the faces moved inwards by r. Exact on both sides. Cost:
//! some ten flops.

/// What a corner is to a point: the distance, its gradient `[N]` along the q, unit, and one
/// over the distance from the edge or corner that is nearest, zero at a face.
pub(super) struct CornerContact<const N: usize> {
    pub(super) distance: f64,
    pub(super) normal: [f64; N],
    pub(super) curvature: f64,
}

/// The corner seen from `beyond` `[N]`, the q.
pub(super) fn corner<const N: usize>(beyond: [f64; N], rounding: f64) -> CornerContact<N> {
    let positive = beyond.map(|q| q.max(0.0));
    let many = beyond.iter().filter(|q| **q > 0.0).count();
    if many > 1 {
        let length = positive.iter().map(|q| q * q).sum::<f64>().sqrt();
        return CornerContact {
            distance: length - rounding,
            normal: positive.map(|q| q / length),
            curvature: 1.0 / length,
        };
    }
    let nearest = (1..N).fold(0, |nearest, i| {
        if beyond[i] > beyond[nearest] {
            i
        } else {
            nearest
        }
    });
    let mut normal = [0.0; N];
    normal[nearest] = 1.0;
    CornerContact {
        distance: beyond[nearest] - rounding,
        normal,
        curvature: 0.0,
    }
}
