//! A triangulated surface as an obstacle.

use std::sync::Arc;

use super::geometry::Geometry;
use super::{Interpolation, SurfaceShape, TriangulatedSurface};
use crate::geometry::vector3::scale;
use crate::obstacle::{Ball, Contact, Derivatives, Obstacle, ObstacleError, check_length};

/// Patches over the facets of a surface. Reference point is the origin of its coordinates.
#[derive(Clone, Debug)]
pub struct Triangulated {
    surface: Arc<TriangulatedSurface>,
    pub(super) geometry: Arc<Geometry>,
    /// What one length of the geometry is here.
    factor: f64,
}

impl Triangulated {
    /// The tool of `shape`, its lengths divided by `length`. The first one of a surface takes
    /// its time, others share what it has made.
    ///
    /// # Errors
    /// The scale is not finite or not above zero, or the feature angle is not an angle.
    pub fn new(shape: &SurfaceShape, length: f64) -> Result<Self, ObstacleError> {
        check_length("scale", shape.scale)?;
        check_angle(shape.between)?;
        let geometry = shape.surface.geometry(shape.between);
        Ok(Self {
            surface: Arc::clone(&shape.surface),
            factor: shape.scale * geometry.unit / length,
            geometry,
        })
    }

    /// The triangulation.
    pub fn surface(&self) -> &TriangulatedSurface {
        &self.surface
    }
}

fn check_angle(between: Interpolation) -> Result<(), ObstacleError> {
    match between {
        Interpolation::Facets => Ok(()),
        Interpolation::Patches(angle) if angle > 0.0 && angle < std::f64::consts::PI => Ok(()),
        Interpolation::Patches(value) => Err(ObstacleError::NotBetweenFacets {
            parameter: "feature_angle",
            degrees: value.to_degrees(),
        }),
    }
}

impl Obstacle for Triangulated {
    fn probe(&self, points: &[[f64; 3]], derivatives: Derivatives, out: &mut [Contact]) {
        // Neighbours in a batch are near each other, and so are their nearest points.
        let places = points.iter().map(|point| point.map(|x| x / self.factor));
        self.geometry.contacts(places, derivatives, out);
        for contact in out {
            contact.distance *= self.factor;
            if derivatives == Derivatives::Curvature {
                let rows = contact.curvature.as_flattened_mut().iter_mut();
                rows.for_each(|entry| *entry /= self.factor);
            }
        }
    }

    fn reference_point(&self) -> [f64; 3] {
        [0.0; 3]
    }

    fn is_flat(&self) -> bool {
        false
    }

    fn inner_ball(&self) -> Option<Ball> {
        let ball = self.geometry.ball?;
        Some(Ball {
            centre: scale(self.factor, ball.centre),
            radius: self.factor * ball.radius,
        })
    }

    fn sharpest_radius(&self) -> Option<f64> {
        self.geometry.sharpest.map(|radius| self.factor * radius)
    }

    fn is_smooth(&self) -> bool {
        self.geometry.is_smooth
    }

    fn is_closed(&self) -> bool {
        true
    }

    fn lies_in_plane(&self) -> Result<(), ObstacleError> {
        Err(ObstacleError::OutOfPlane { parameter: "kind" })
    }
}
