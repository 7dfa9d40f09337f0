//! All points behind a plane: d(x) = n · (x − p), H = 0.
//!
//! n the unit normal towards the free side, p a point of the plane, lengths those of the
//! caller of the shape. Exact and linear: it adds no curvature to a tangent.

use super::{
    Ball, Contact, Derivatives, Obstacle, ObstacleError, check_direction, check_plane, check_point,
};
use crate::geometry::vector3::{dot, sub};

/// A half-space whose plane passes through its reference point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// A point of the plane and the reference point, length.
    point: [f64; 3],
    /// Unit normal towards the free side.
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
    fn probe(&self, points: &[[f64; 3]], derivatives: Derivatives, out: &mut [Contact]) {
        for (contact, &point) in out.iter_mut().zip(points) {
            contact.distance = dot(self.normal, sub(point, self.point));
            if derivatives >= Derivatives::Normal {
                contact.normal = self.normal;
            }
            if derivatives >= Derivatives::Curvature {
                contact.curvature = [[0.0; 3]; 3];
            }
        }
    }

    fn reference_point(&self) -> [f64; 3] {
        self.point
    }

    fn is_flat(&self) -> bool {
        true
    }

    fn inner_ball(&self) -> Option<Ball> {
        None
    }

    fn sharpest_radius(&self) -> Option<f64> {
        None
    }

    fn is_smooth(&self) -> bool {
        true
    }

    fn is_closed(&self) -> bool {
        false
    }

    fn lies_in_plane(&self) -> Result<(), ObstacleError> {
        check_plane("normal", self.normal[2])
    }
}
