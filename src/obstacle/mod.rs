//! Rigid obstacles as signed distances d(x): positive on the free side.
//!
//! Shapes are exact: d, its gradient n (unit, towards the free side) and its
//! Hessian H (symmetric, H n = 0) come in closed form. [`Moving`] carries a
//! shape along a rigid motion. Where the nearest point is not unique (the
//! centre of a sphere, the axis of a cylinder) the normal is a fixed direction
//! that the shape documents and the Hessian is zero, so all values are finite.
//! A shape computes what is asked for, for a batch of points at a time. Lengths are
//! the caller's. Cost: some tens of flops per point.
//!
//! A new shape is a file beside this one, a variant of [`Shape`] and a line in
//! [`Shape::build`]; the compiler names the two other places that tell shapes apart, and the table
//! in the library's documentation the files outside.

mod capped_cylinder;
mod cavity;
mod cone;
mod corner;
mod cuboid;
mod cylinder;
mod error;
pub mod grid;
mod half_space;
mod moving;
mod revolution;
mod shape;
mod sphere;
pub mod surface;
mod torus;

use std::fmt;

pub use cavity::Cavity;
pub use cuboid::Cuboid;
pub use cylinder::Cylinder;
pub use error::ObstacleError;
pub use half_space::HalfSpace;
pub use moving::Moving;
pub use shape::Shape;
pub use sphere::Sphere;

use crate::geometry::Matrix3;
use crate::geometry::vector3::{is_finite, normalised, scale, sub};

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

/// How much of a [`Contact`] is computed; each includes what stands before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Derivatives {
    /// The distance alone; normal and curvature keep what they held.
    Gap,
    /// The distance and the unit normal.
    Normal,
    /// The distance, the normal and the curvature, as tangents of curved shapes need
    /// them.
    Curvature,
}

/// A ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Centre `[3]`.
    pub centre: [f64; 3],
    /// Radius, length.
    pub radius: f64,
}

/// A rigid body that points cannot enter.
pub trait Obstacle: fmt::Debug + Send + Sync {
    /// What the obstacle is to each of `points` `[points][3]`, into `out`
    /// `[points]`; what is not asked for stays there as it was. The numbers of a
    /// point depend on that point alone.
    fn probe(&self, points: &[[f64; 3]], derivatives: Derivatives, out: &mut [Contact]);

    /// The point `[3]` that rotations leave in place and moments refer to.
    fn reference_point(&self) -> [f64; 3];

    /// Whether the distance is linear in the point.
    fn is_flat(&self) -> bool;

    /// A largest ball inside; none where there is no largest.
    fn inner_ball(&self) -> Option<Ball>;

    /// Smallest radius of curvature of the convex parts of the surface, a length, zero at sharp
    /// edges; none where no part is convex.
    fn sharpest_radius(&self) -> Option<f64>;

    /// Whether the normal turns without jumps of its rate: the curvature is continuous.
    fn is_smooth(&self) -> bool;

    /// Whether the shape has an inside that a body may lie in, in place of the outside.
    fn is_closed(&self) -> bool;

    /// Whether the distance changes by no more than a point moves; values on a grid may be
    /// steeper.
    fn has_exact_distances(&self) -> bool {
        true
    }

    /// Whether a body in the plane z = 0 meets the shape in that plane only: its
    /// normals there have no z.
    ///
    /// # Errors
    /// [`ObstacleError::OutOfPlane`] with the parameter that says otherwise.
    fn lies_in_plane(&self) -> Result<(), ObstacleError>;

    /// Signed distance, normal and curvature at one point `[3]`.
    fn distance(&self, point: [f64; 3]) -> Contact {
        let mut out = [Contact::default()];
        self.probe(&[point], Derivatives::Curvature, &mut out);
        let [contact] = out;
        contact
    }
}

/// The point, refused by the name of its parameter where it is not finite.
fn check_point(parameter: &'static str, point: [f64; 3]) -> Result<[f64; 3], ObstacleError> {
    if is_finite(point) {
        Ok(point)
    } else {
        Err(ObstacleError::NotFinite { parameter })
    }
}

/// The direction as a unit vector, refused where it is not finite or has no length.
fn check_direction(
    parameter: &'static str,
    direction: [f64; 3],
) -> Result<[f64; 3], ObstacleError> {
    check_point(parameter, direction)?;
    normalised(direction).ok_or(ObstacleError::ZeroLength { parameter })
}

/// The length, refused where it is not finite or not above zero.
fn check_length(parameter: &'static str, length: f64) -> Result<f64, ObstacleError> {
    if !length.is_finite() {
        Err(ObstacleError::NotFinite { parameter })
    } else if length > 0.0 {
        Ok(length)
    } else {
        Err(ObstacleError::NotPositive {
            parameter,
            value: length,
        })
    }
}

/// The rounding, refused where it is not finite, negative or above `limit`.
fn check_rounding(rounding: f64, limit: f64) -> Result<f64, ObstacleError> {
    let parameter = "rounding";
    if !rounding.is_finite() {
        Err(ObstacleError::NotFinite { parameter })
    } else if rounding < 0.0 {
        let value = rounding;
        Err(ObstacleError::Negative { parameter, value })
    } else if rounding > limit {
        let value = rounding;
        Err(ObstacleError::TooLarge {
            parameter,
            value,
            limit,
        })
    } else {
        Ok(rounding)
    }
}

/// Refuses a `component` off the plane of a flat body.
fn check_plane(parameter: &'static str, component: f64) -> Result<(), ObstacleError> {
    if component == 0.0 {
        Ok(())
    } else {
        Err(ObstacleError::OutOfPlane { parameter })
    }
}

/// Whether a distance from a centre or axis is too small for a direction.
fn is_central(distance: f64, radius: f64) -> bool {
    distance <= f64::EPSILON * radius
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

/// The larger principal curvature of a surface, from the second derivative of its distance, one
/// eigenvalue of which is zero.
pub(crate) fn larger_curvature(curvature: &Matrix3) -> f64 {
    let half = 0.5 * (0..3).map(|i| curvature[i][i]).sum::<f64>();
    let squares: f64 = curvature.as_flattened().iter().map(|x| x * x).sum();
    half + (0.5 * squares - half * half).max(0.0).sqrt()
}

#[cfg(test)]
mod tests;
