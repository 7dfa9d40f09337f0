//! Shapes as scenes give them.

use std::sync::Arc;

use super::capped_cylinder::capped_cylinder;
use super::cone::cone;
use super::grid::{DistanceGrid, HeightField, Sampled};
use super::surface::{SurfaceShape, Triangulated};
use super::torus::torus;
use super::{Cavity, Cuboid, Cylinder, HalfSpace, Obstacle, ObstacleError, Sphere};

/// A shape as scenes give it, in its initial pose and in the caller's lengths.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// All points behind a plane, which the body may touch from the free side.
    HalfSpace {
        /// A point of the plane, and the reference point.
        point: [f64; 3],
        /// Towards the free side; any length above zero.
        normal: [f64; 3],
    },
    /// A ball, which the body may touch from outside.
    Sphere {
        /// Centre, and the reference point.
        centre: [f64; 3],
        /// Above zero.
        radius: f64,
    },
    /// An infinite circular cylinder, which the body may touch from outside.
    Cylinder {
        /// A point of the axis, and the reference point.
        point: [f64; 3],
        /// Any length above zero.
        axis: [f64; 3],
        /// Above zero.
        radius: f64,
    },
    /// A circular cylinder between two points.
    CappedCylinder {
        /// Middle of one end, and the reference point.
        from: [f64; 3],
        /// Middle of the other end.
        to: [f64; 3],
        /// Above zero.
        radius: f64,
        /// Radius of the rims, at most the radius and half the length.
        rounding: f64,
    },
    /// A box along the axes.
    Box {
        /// Centre, and the reference point.
        centre: [f64; 3],
        /// Half the sizes, above zero.
        half_sizes: [f64; 3],
        /// Radius of edges and corners, at most the least half size.
        rounding: f64,
    },
    /// A torus.
    Torus {
        /// Centre, and the reference point.
        centre: [f64; 3],
        /// Any length above zero.
        axis: [f64; 3],
        /// Of the circle that the tube follows.
        radius: f64,
        /// Of the tube, below the other.
        tube_radius: f64,
    },
    /// An infinite circular cone.
    Cone {
        /// Where its straight sides would meet, and the reference point.
        apex: [f64; 3],
        /// From the apex into the cone, any length above zero.
        axis: [f64; 3],
        /// Between axis and side, radians, below a right angle.
        angle: f64,
        /// Radius of the ball that rounds the tip.
        rounding: f64,
    },
    /// A triangulated surface, its origin the reference point.
    Surface(SurfaceShape),
    /// All points below heights over a plane, its origin the reference point.
    HeightField(Arc<HeightField>),
    /// All points of negative distance, its origin the reference point.
    DistanceGrid(Arc<DistanceGrid>),
    /// A closed shape as a cavity, the body inside it.
    Cavity(Arc<Shape>),
}

impl Shape {
    /// The obstacle with all lengths divided by `length`.
    ///
    /// # Errors
    /// The first parameter that has no meaning.
    pub fn build(&self, length: f64) -> Result<Arc<dyn Obstacle>, ObstacleError> {
        let place = |point: &[f64; 3]| point.map(|x| x / length);
        Ok(match self {
            Self::HalfSpace { point, normal } => Arc::new(HalfSpace::new(place(point), *normal)?),
            Self::Sphere { centre, radius } => {
                Arc::new(Sphere::new(place(centre), radius / length)?)
            }
            Self::Cylinder {
                point,
                axis,
                radius,
            } => Arc::new(Cylinder::new(place(point), *axis, radius / length)?),
            Self::CappedCylinder {
                from,
                to,
                radius,
                rounding,
            } => Arc::new(capped_cylinder(
                (place(from), place(to)),
                (radius / length, rounding / length),
            )?),
            Self::Box {
                centre,
                half_sizes,
                rounding,
            } => Arc::new(Cuboid::new(
                place(centre),
                place(half_sizes),
                rounding / length,
            )?),
            Self::Torus {
                centre,
                axis,
                radius,
                tube_radius,
            } => Arc::new(torus(
                (place(centre), *axis),
                (radius / length, tube_radius / length),
            )?),
            Self::Cone {
                apex,
                axis,
                angle,
                rounding,
            } => Arc::new(cone((place(apex), *axis), (*angle, rounding / length))?),
            Self::Surface(shape) => Arc::new(Triangulated::new(shape, length)?),
            Self::HeightField(grid) => Arc::new(Sampled::new(grid, length)),
            Self::DistanceGrid(grid) => Arc::new(Sampled::new(grid, length)),
            Self::Cavity(shape) => Arc::new(Cavity::new(shape.build(length)?)?),
        })
    }
}
