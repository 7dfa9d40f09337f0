//! A ball: d(x) = |x − c| − R, n = (x − c)/|x − c|, H = (I − n nᵀ)/|x − c|.

use super::{
    Contact, Obstacle, ObstacleError, check_point, check_radius, is_central, round_curvature,
};
use crate::geometry::vector3::{norm, scale, sub};

/// A ball with its centre as reference point. At the centre the normal is +x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    centre: [f64; 3],
    radius: f64,
}

impl Sphere {
    /// `centre` `[3]` and `radius`, length.
    ///
    /// # Errors
    /// A number is not finite or the radius is not above zero.
    pub fn new(centre: [f64; 3], radius: f64) -> Result<Self, ObstacleError> {
        Ok(Self {
            centre: check_point("centre", centre)?,
            radius: check_radius(radius)?,
        })
    }
}

impl Obstacle for Sphere {
    fn distance(&self, point: [f64; 3]) -> Contact {
        let offset = sub(point, self.centre);
        let length = norm(offset);
        if is_central(length, self.radius) {
            return Contact {
                distance: length - self.radius,
                normal: [1.0, 0.0, 0.0],
                curvature: [[0.0; 3]; 3],
            };
        }
        let normal = scale(1.0 / length, offset);
        Contact {
            distance: length - self.radius,
            normal,
            curvature: round_curvature(normal, [0.0; 3], length),
        }
    }

    fn reference_point(&self) -> [f64; 3] {
        self.centre
    }
}
