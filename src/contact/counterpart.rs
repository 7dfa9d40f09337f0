//! What a face of the body meets: an obstacle, the same for every face, or a guide
//! that holds each face in its own plane.
//!
//! All that an integral asks of it is the signed distance d of a deformed point, positive
//! outside, its normal and its curvature; lengths are those of the scaled body.

use super::face::ContactFace;
use crate::geometry::rigid_motion::multiply;
use crate::geometry::vector3::{dot, scale, sub};
use crate::geometry::{Matrix3, RigidMotion};
use crate::obstacle::{Contact, Obstacle, What};

/// What a face meets.
pub trait Counterpart: Sync {
    /// What it is to `points` `[points, 3]` of `face`, into `out` `[points]`.
    fn probe_on(&self, face: &ContactFace, points: &[[f64; 3]], what: What, out: &mut [Contact]);
}

impl<T: Obstacle + ?Sized> Counterpart for T {
    fn probe_on(&self, _: &ContactFace, points: &[[f64; 3]], what: What, out: &mut [Contact]) {
        self.probe(points, what, out);
    }
}

/// Holds the normal component of a surface that a support carries along:
///
/// ```text
/// d = value - R N . (x - m(X)),   m the motion of the support, R its rotation
/// ```
///
/// N the outward normal of the undeformed face, X any of its points: points slide in
/// the plane of their face. d is linear in x. Lengths as those of the faces.
#[derive(Clone, Copy, Debug)]
pub struct Guide {
    /// Rigid motion of the support from its first place, lengths as those of the faces.
    motion: RigidMotion,
    /// Rotation of that motion as a matrix, made once for all faces.
    rotation: Matrix3,
    /// Normal displacement that the support prescribes, positive outwards, in units of
    /// the scaled body.
    value: f64,
}

impl Guide {
    /// Of a support that has moved by `motion` and holds the normal displacement at
    /// `value`, positive outwards.
    pub fn new(motion: RigidMotion, value: f64) -> Self {
        Self {
            rotation: motion.matrix(),
            motion,
            value,
        }
    }
}

impl Counterpart for Guide {
    fn probe_on(&self, face: &ContactFace, points: &[[f64; 3]], what: What, out: &mut [Contact]) {
        let normal = multiply(&self.rotation, face.normal);
        let origin = self.motion.apply(face.point);
        for (contact, &point) in out.iter_mut().zip(points) {
            contact.distance = self.value - dot(normal, sub(point, origin));
            if what >= What::Normal {
                contact.normal = scale(-1.0, normal);
            }
            if what >= What::Curvature {
                contact.curvature = [[0.0; 3]; 3];
            }
        }
    }
}
