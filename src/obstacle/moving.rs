//! A shape carried by a rigid motion m(x) = c + R(x − c) + t:
//! d'(x) = d(m⁻¹ x), n' = R n, H' = R H Rᵀ.

use std::sync::Arc;

use super::{Ball, Contact, Derivatives, Obstacle, ObstacleError};
use crate::geometry::rigid_motion::{conjugate, multiply, multiply_transposed};
use crate::geometry::vector3::{add, sub};
use crate::geometry::{Matrix3, RigidMotion};

/// Points that are turned back at a time, on the stack.
const BATCH: usize = 32;

/// A shape away from its initial pose.
#[derive(Clone, Debug)]
pub struct Moving {
    /// The shape in its initial pose.
    shape: Arc<dyn Obstacle>,
    /// How the shape has moved from its initial pose.
    motion: RigidMotion,
    /// Rotation of that motion as a matrix, made once for all points.
    rotation: Matrix3,
}

impl Moving {
    /// Turns `shape` by the rotation vector `[3]` (radians) about its reference
    /// point, then shifts it by `translation` `[3]`, both from its own pose.
    pub fn new(shape: Arc<dyn Obstacle>, translation: [f64; 3], rotation: [f64; 3]) -> Self {
        let about = shape.reference_point();
        let motion = RigidMotion {
            translation,
            rotation,
            about,
        };
        Self {
            shape,
            motion,
            rotation: motion.matrix(),
        }
    }

    /// m^-1 of a point `[3]`.
    fn own_frame(&self, point: [f64; 3]) -> [f64; 3] {
        let about = self.motion.about;
        let offset = sub(sub(point, about), self.motion.translation);
        add(about, multiply_transposed(&self.rotation, offset))
    }

    /// The motion from the shape's own pose.
    pub fn motion(&self) -> RigidMotion {
        self.motion
    }
}

impl Obstacle for Moving {
    fn probe(&self, points: &[[f64; 3]], derivatives: Derivatives, out: &mut [Contact]) {
        let mut own = [[0.0; 3]; BATCH];
        for (points, out) in points.chunks(BATCH).zip(out.chunks_mut(BATCH)) {
            let own = &mut own[..points.len()];
            for (own, &point) in own.iter_mut().zip(points) {
                *own = self.own_frame(point);
            }
            self.shape.probe(own, derivatives, out);
            if derivatives >= Derivatives::Normal {
                out.iter_mut()
                    .for_each(|contact| contact.normal = multiply(&self.rotation, contact.normal));
            }
            if derivatives >= Derivatives::Curvature {
                out.iter_mut().for_each(|contact| {
                    contact.curvature = conjugate(&self.rotation, &contact.curvature);
                });
            }
        }
    }

    fn reference_point(&self) -> [f64; 3] {
        add(self.motion.about, self.motion.translation)
    }

    fn is_flat(&self) -> bool {
        self.shape.is_flat()
    }

    fn inner_ball(&self) -> Option<Ball> {
        self.shape.inner_ball().map(|ball| Ball {
            centre: self.motion.apply(ball.centre),
            ..ball
        })
    }

    fn sharpest_radius(&self) -> Option<f64> {
        self.shape.sharpest_radius()
    }

    fn is_smooth(&self) -> bool {
        self.shape.is_smooth()
    }

    fn has_exact_distances(&self) -> bool {
        self.shape.has_exact_distances()
    }

    fn is_closed(&self) -> bool {
        self.shape.is_closed()
    }

    /// As the shape does in its own pose: scenes move a flat body's obstacles in the
    /// plane only.
    fn lies_in_plane(&self) -> Result<(), ObstacleError> {
        self.shape.lies_in_plane()
    }
}
