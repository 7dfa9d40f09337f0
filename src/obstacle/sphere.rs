//! A ball: d(x) = |x − c| − R, n = (x − c)/|x − c|, H = (I − n nᵀ)/|x − c|.
//!
//! c the centre, R the radius. H grows like 1/|x − c| inwards; a body does not get there
//! unless it has passed through the surface.

use super::{
    Ball, Contact, Derivatives, Obstacle, ObstacleError, check_length, check_plane, check_point,
    is_central, round_curvature,
};
use crate::geometry::vector3::{norm, scale, sub};

/// A ball with its centre as reference point. At the centre the normal is +x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre and reference point, length.
    centre: [f64; 3],
    /// Radius, length, above zero.
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
            radius: check_length("radius", radius)?,
        })
    }
}

impl Obstacle for Sphere {
    fn probe(&self, points: &[[f64; 3]], derivatives: Derivatives, out: &mut [Contact]) {
        for (contact, &point) in out.iter_mut().zip(points) {
            let offset = sub(point, self.centre);
            let length = norm(offset);
            contact.distance = length - self.radius;
            if derivatives == Derivatives::Gap {
                continue;
            }
            let is_central = is_central(length, self.radius);
            contact.normal = if is_central {
                [1.0, 0.0, 0.0]
            } else {
                scale(1.0 / length, offset)
            };
            if derivatives == Derivatives::Curvature {
                contact.curvature = if is_central {
                    [[0.0; 3]; 3]
                } else {
                    round_curvature(contact.normal, [0.0; 3], length)
                };
            }
        }
    }

    fn reference_point(&self) -> [f64; 3] {
        self.centre
    }

    fn is_flat(&self) -> bool {
        false
    }

    fn inner_ball(&self) -> Option<Ball> {
        Some(Ball {
            centre: self.centre,
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
        check_plane("centre", self.centre[2])
    }
}
