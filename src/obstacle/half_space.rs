//! All points behind a plane: d(x) = n · (x − p), H = 0.

use super::{Contact, Obstacle, ObstacleError, check_direction, check_point};
use crate::geometry::vector3::{dot, sub};

/// A half-space whose plane passes through its reference point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    point: [f64; 3],
    normal: [f64; 3],
}

impl HalfSpace {
    /// `point` `[3]` of the plane; `normal` `[3]` towards the free side, of any length.
    ///
    /// # Errors
    /// A component is not finite or the normal is zero.
    pub fn new(point: [f64; 3], normal: [f64; 3]) -> Result<Self, ObstacleError> {
        Ok(Self {
            point: check_point("point", point)?,
            normal: check_direction("normal", normal)?,
        })
    }
}

impl Obstacle for HalfSpace {
    fn distance(&self, point: [f64; 3]) -> Contact {
        Contact {
            distance: dot(self.normal, sub(point, self.point)),
            normal: self.normal,
            curvature: [[0.0; 3]; 3],
        }
    }

    fn reference_point(&self) -> [f64; 3] {
        self.point
    }
}
