//! A shape carried by a rigid motion m(x) = c + R(x − c) + t:
//! d'(x) = d(m⁻¹ x), n' = R n, H' = R H Rᵀ.

use std::sync::Arc;

use super::{Contact, Obstacle};
use crate::geometry::rigid_motion::{conjugate, multiply, multiply_transposed};
use crate::geometry::vector3::{add, sub};
use crate::geometry::{Matrix3, RigidMotion};

/// A shape away from its initial pose.
#[derive(Clone, Debug)]
pub struct Moving {
    shape: Arc<dyn Obstacle>,
    motion: RigidMotion,
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

    /// The motion from the shape's own pose.
    pub fn motion(&self) -> RigidMotion {
        self.motion
    }
}

impl Obstacle for Moving {
    fn distance(&self, point: [f64; 3]) -> Contact {
        let about = self.motion.about;
        let offset = sub(sub(point, about), self.motion.translation);
        let still = self
            .shape
            .distance(add(about, multiply_transposed(&self.rotation, offset)));
        Contact {
            distance: still.distance,
            normal: multiply(&self.rotation, still.normal),
            curvature: conjugate(&self.rotation, &still.curvature),
        }
    }

    fn reference_point(&self) -> [f64; 3] {
        add(self.motion.about, self.motion.translation)
    }
}
