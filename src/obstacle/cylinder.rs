//! An infinite circular cylinder: with w the part of x − p across the axis a,
//! d(x) = |w| − R, n = w/|w|, H = (I − a aᵀ − n nᵀ)/|w|.

use super::{
    Ball, Contact, Derivatives, Obstacle, ObstacleError, check_direction, check_length,
    check_plane, check_point, is_central, orthogonal, round_curvature,
};
use crate::geometry::vector3::{dot, norm, scale, sub};

/// An infinite cylinder whose axis passes through its reference point. On the
/// axis the normal is the coordinate direction farthest from the axis, made
/// orthogonal to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// A point of the axis and the reference point, length.
    point: [f64; 3],
    /// Unit vector along the axis.
    axis: [f64; 3],
    /// Radius, length, above zero.
    radius: f64,
    /// The unit normal where a point lies on the axis, orthogonal to it: every other
    /// choice would be as good, this one is fixed.
    sideways: [f64; 3],
}

impl Cylinder {
    /// `point` `[3]` of the axis, `axis` `[3]` of any length, `radius`, length.
    ///
    /// # Errors
    /// A number is not finite, the axis is zero or the radius is not above zero.
    pub fn new(point: [f64; 3], axis: [f64; 3], radius: f64) -> Result<Self, ObstacleError> {
        let axis = check_direction("axis", axis)?;
        Ok(Self {
            point: check_point("point", point)?,
            axis,
            radius: check_length("radius", radius)?,
            sideways: orthogonal(axis),
        })
    }

    /// The part of a point's offset from the axis that is orthogonal to it, length.
    fn across(&self, point: [f64; 3]) -> [f64; 3] {
        let offset = sub(point, self.point);
        sub(offset, scale(dot(offset, self.axis), self.axis))
    }
}

impl Obstacle for Cylinder {
    fn probe(&self, points: &[[f64; 3]], derivatives: Derivatives, out: &mut [Contact]) {
        for (contact, &point) in out.iter_mut().zip(points) {
            let across = self.across(point);
            let length = norm(across);
            contact.distance = length - self.radius;
            if derivatives == Derivatives::Gap {
                continue;
            }
            let is_central = is_central(length, self.radius);
            contact.normal = if is_central {
                self.sideways
            } else {
                scale(1.0 / length, across)
            };
            if derivatives == Derivatives::Curvature {
                contact.curvature = if is_central {
                    [[0.0; 3]; 3]
                } else {
                    round_curvature(contact.normal, self.axis, length)
                };
            }
        }
    }

    fn reference_point(&self) -> [f64; 3] {
        self.point
    }

    fn is_flat(&self) -> bool {
        false
    }

    fn inner_ball(&self) -> Option<Ball> {
        Some(Ball {
            centre: self.point,
            radius: self.radius,
        })
    }

    fn sharpest_radius(&self) -> Option<f64> {
        Some(self.radius)
    }

    fn is_smooth(&self) -> bool {
        true
    }

    fn is_closed(&self) -> bool {
        true
    }

    fn lies_in_plane(&self) -> Result<(), ObstacleError> {
        check_plane("axis", self.axis[0]).and_then(|()| check_plane("axis", self.axis[1]))
    }
}
