//! Whether the nodes are close enough for the surface between them.

use super::error::GridError;
use super::foot::Frame;

/// Radii of curvature over the spacing that a surface needs.
const SPACINGS: f64 = 3.0;

/// The largest curvatures of a surface, one over length.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bends {
    /// Of its convex parts; zero where it has none.
    pub(super) convex: f64,
}

impl Bends {
    /// Takes a place of the surface up, near `node`; `spacing` is the largest of the grid.
    ///
    /// # Errors
    /// [`GridError::Coarse`].
    pub(super) fn join(
        self,
        frame: &Frame,
        (node, spacing): (&[usize], f64),
    ) -> Result<Self, GridError> {
        let [low, high] = frame.curvatures();
        let largest = high.max(-low);
        // Not the other way around: NaN is refused.
        let is_fine = largest * spacing * SPACINGS <= 1.0;
        is_fine
            .then_some(Self {
                convex: self.convex.max(high),
            })
            .ok_or_else(|| GridError::Coarse {
                node: node.to_vec(),
                radius: 1.0 / largest,
                spacing,
            })
    }

    /// Smallest radius of the convex parts; none where they are flat beside `size`.
    pub(super) fn sharpest_radius(self, size: f64) -> Option<f64> {
        (self.convex * size > FLAT).then(|| 1.0 / self.convex)
    }
}

/// Curvature times the size of a surface that is rounding only.
const FLAT: f64 = 1e-9;
