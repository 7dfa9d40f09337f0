//! How deep rays of a face look inwards, from corner to corner along a plane.

use super::patch::At;

/// How deep rays of a face look inwards: at its first corner, and how that changes by l_1 and l_2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Depth {
    first: f64,
    slopes: [f64; 2],
}

impl Depth {
    /// The same all over.
    pub(super) fn even(first: f64) -> Self {
        Self {
            first,
            slopes: [0.0; 2],
        }
    }

    /// By its corners.
    pub(super) fn of_corners([a, b, c]: [f64; 3]) -> Self {
        Self {
            first: a,
            slopes: [b - a, c - a],
        }
    }

    /// At a place.
    pub(super) fn at(self, [s, t]: At) -> f64 {
        self.first + s * self.slopes[0] + t * self.slopes[1]
    }
}
