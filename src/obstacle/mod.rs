//! Rigid obstacles as signed distances d(x): positive on the free side.
//!
//! Shapes are exact: d, its gradient n (unit, towards the free side) and its
//! Hessian H (symmetric, H n = 0) come in closed form. [`Moving`] carries a
//! shape along a rigid motion. Where the nearest point is not unique (the
//! centre of a sphere, the axis of a cylinder) the normal is a fixed direction
//! that the shape documents and the Hessian is zero, so all values are finite.
//! Lengths are the caller's. Cost: some tens of flops per point.

mod cylinder;
mod error;
mod half_space;
mod moving;
mod sphere;

use std::fmt;

pub use cylinder::Cylinder;
pub use error::ObstacleError;
pub use half_space::HalfSpace;
pub use moving::Moving;
pub use sphere::Sphere;

use crate::geometry::Matrix3;
use crate::geometry::vector3::{is_finite, normalised};

/// What an obstacle is to a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Signed distance, length; above zero outside the obstacle.
    pub distance: f64,
    /// Gradient of the distance `[3]`, unit, from the obstacle to the free side.
    pub normal: [f64; 3],
    /// Hessian of the distance `[3, 3]`, one over length.
    pub curvature: Matrix3,
}

/// A rigid body that points cannot enter.
pub trait Obstacle: fmt::Debug + Send + Sync {
    /// Signed distance, normal and curvature at a point `[3]`.
    fn distance(&self, point: [f64; 3]) -> Contact;

    /// The point `[3]` that rotations leave in place and moments refer to.
    fn reference_point(&self) -> [f64; 3];

    /// [`Obstacle::distance`] at each of `points` into `out`, of equal length.
    fn probe(&self, points: &[[f64; 3]], out: &mut [Contact]) {
        debug_assert_eq!(points.len(), out.len(), "one result per point");
        for (contact, &point) in out.iter_mut().zip(points) {
            *contact = self.distance(point);
        }
    }
}

fn check_point(parameter: &'static str, point: [f64; 3]) -> Result<[f64; 3], ObstacleError> {
    if is_finite(point) {
        Ok(point)
    } else {
        Err(ObstacleError::NotFinite { parameter })
    }
}

fn check_direction(
    parameter: &'static str,
    direction: [f64; 3],
) -> Result<[f64; 3], ObstacleError> {
    check_point(parameter, direction)?;
    normalised(direction).ok_or(ObstacleError::ZeroLength { parameter })
}

fn check_radius(radius: f64) -> Result<f64, ObstacleError> {
    let parameter = "radius";
    if !radius.is_finite() {
        Err(ObstacleError::NotFinite { parameter })
    } else if radius > 0.0 {
        Ok(radius)
    } else {
        Err(ObstacleError::NotPositive {
            parameter,
            value: radius,
        })
    }
}

/// Whether a distance from a centre or axis is too small for a direction.
fn is_central(distance: f64, radius: f64) -> bool {
    distance <= f64::EPSILON * radius
}

/// (P − n nᵀ)/r with P = I − a aᵀ: curvature of a round surface at distance r
/// from its centre (a = 0) or from its axis of direction a.
fn round_curvature(normal: [f64; 3], axis: [f64; 3], distance: f64) -> Matrix3 {
    let mut curvature = [[0.0; 3]; 3];
    for row in 0..3 {
        for column in 0..3 {
            let identity = if row == column { 1.0 } else { 0.0 };
            let removed = normal[row] * normal[column] + axis[row] * axis[column];
            curvature[row][column] = (identity - removed) / distance;
        }
    }
    curvature
}

#[cfg(test)]
mod tests;
