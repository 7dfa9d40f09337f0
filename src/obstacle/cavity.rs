//! The outside of a closed shape as the obstacle, the body inside it: d' = -d, n' = -n,
//! H' = -H.

use std::sync::Arc;

use super::{Ball, Contact, Derivatives, Obstacle, ObstacleError};
use crate::geometry::vector3::scale;

/// A shape turned inside out.
#[derive(Clone, Debug)]
pub struct Cavity {
    shape: Arc<dyn Obstacle>,
}

impl Cavity {
    /// The cavity in the form of `shape`.
    ///
    /// # Errors
    /// The shape has no inside.
    pub fn new(shape: Arc<dyn Obstacle>) -> Result<Self, ObstacleError> {
        if shape.is_closed() {
            Ok(Self { shape })
        } else {
            Err(ObstacleError::NotClosed {
                parameter: "inside",
            })
        }
    }
}

impl Obstacle for Cavity {
    fn probe(&self, points: &[[f64; 3]], derivatives: Derivatives, out: &mut [Contact]) {
        self.shape.probe(points, derivatives, out);
        for contact in out.iter_mut().take(points.len()) {
            contact.distance = -contact.distance;
            if derivatives >= Derivatives::Normal {
                contact.normal = scale(-1.0, contact.normal);
            }
            if derivatives >= Derivatives::Curvature {
                contact.curvature = contact.curvature.map(|row| scale(-1.0, row));
            }
        }
    }

    fn reference_point(&self) -> [f64; 3] {
        self.shape.reference_point()
    }

    fn is_flat(&self) -> bool {
        false
    }

    fn inner_ball(&self) -> Option<Ball> {
        None
    }

    /// A cavity has no convex part.
    fn sharpest_radius(&self) -> Option<f64> {
        None
    }

    fn is_smooth(&self) -> bool {
        self.shape.is_smooth()
    }

    fn has_exact_distances(&self) -> bool {
        self.shape.has_exact_distances()
    }

    fn is_closed(&self) -> bool {
        false
    }

    fn lies_in_plane(&self) -> Result<(), ObstacleError> {
        self.shape.lies_in_plane()
    }
}
