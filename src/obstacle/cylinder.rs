//! An infinite circular cylinder: with w the part of x − p across the axis a,
//! d(x) = |w| − R, n = w/|w|, H = (I − a aᵀ − n nᵀ)/|w|.

use super::{
    Contact, Obstacle, ObstacleError, check_direction, check_point, check_radius, is_central,
    round_curvature,
};
use crate::geometry::vector3::{dot, norm, normalised, scale, sub};

/// An infinite cylinder whose axis passes through its reference point. On the
/// axis the normal is the coordinate direction farthest from the axis, made
/// orthogonal to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    point: [f64; 3],
    axis: [f64; 3],
    radius: f64,
    /// The normal on the axis.
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
            radius: check_radius(radius)?,
            sideways: orthogonal(axis),
        })
    }

    fn across(&self, point: [f64; 3]) -> [f64; 3] {
        let offset = sub(point, self.point);
        sub(offset, scale(dot(offset, self.axis), self.axis))
    }
}

impl Obstacle for Cylinder {
    fn distance(&self, point: [f64; 3]) -> Contact {
        let across = self.across(point);
        let length = norm(across);
        if is_central(length, self.radius) {
            return Contact {
                distance: length - self.radius,
                normal: self.sideways,
                curvature: [[0.0; 3]; 3],
            };
        }
        let normal = scale(1.0 / length, across);
        Contact {
            distance: length - self.radius,
            normal,
            curvature: round_curvature(normal, self.axis, length),
        }
    }

    fn reference_point(&self) -> [f64; 3] {
        self.point
    }
}

/// The coordinate direction with the smallest share in `axis`, made orthogonal
/// to it and unit.
fn orthogonal(axis: [f64; 3]) -> [f64; 3] {
    let share = |direction: usize| axis[direction].abs();
    let least = if share(0) <= share(1) && share(0) <= share(2) {
        0
    } else if share(1) <= share(2) {
        1
    } else {
        2
    };
    let mut direction = [0.0; 3];
    direction[least] = 1.0;
    let across = sub(direction, scale(axis[least], axis));
    // The smallest component of a unit vector is below 0.6, so something is left.
    normalised(across).unwrap_or(direction)
}
