//! What a face of the body meets: an obstacle, the same for every face, or a guide
//! that holds each face in its own plane.
//!
//! All that an integral asks of it is the signed distance d of a deformed point, positive
//! outside, its normal and its curvature; lengths are those of the scaled body.

use super::face::ContactFace;
use crate::geometry::rigid_motion::multiply;
use crate::geometry::vector3::{dot, norm, scale, sub};
use crate::geometry::{Matrix3, RigidMotion};
use crate::obstacle::{Contact, Derivatives, Obstacle};

/// Points of a face.
#[derive(Clone, Copy, Debug)]
pub struct Places<'a> {
    /// Barycentric coordinates `[points, 4]`, of which a face uses as many as it has corners.
    pub coordinates: &'a [[f64; 4]],
    /// Where they are in the deformed body `[points, 3]`.
    pub deformed: &'a [[f64; 3]],
}

/// What a face meets.
pub trait Counterpart: Sync {
    /// What it is to `points` of `face`, into `out` `[points]`.
    fn probe_on(
        &self,
        face: &ContactFace,
        points: Places<'_>,
        what: Derivatives,
        out: &mut [Contact],
    );

    /// The share of a segment, from its first corner on, that has something to meet: where that is not
    /// all of it, contact ends with it.
    fn covered(&self, _: &ContactFace) -> [f64; 2] {
        [0.0, 1.0]
    }

    /// The share of a face in space that has something to meet.
    fn share(&self, _: &ContactFace) -> f64 {
        1.0
    }
}

impl<T: Obstacle + ?Sized> Counterpart for T {
    fn probe_on(
        &self,
        _: &ContactFace,
        points: Places<'_>,
        what: Derivatives,
        out: &mut [Contact],
    ) {
        self.probe(points.deformed, what, out);
    }
}

/// Holds the normal component of a surface that a support carries along:
///
/// ```text
/// d = value - R N . (x - m(X)),   m the motion of the support, R its rotation
/// ```
///
/// N the outward normal of the undeformed face where the point X is in it, which a flat face has
/// everywhere: points slide in the tangent plane of their place. d is linear in x. Lengths as
/// those of the faces.
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

    /// A point and a normal of the undeformed surface where the support has them now.
    fn carried(&self, point: [f64; 3], normal: [f64; 3]) -> [[f64; 3]; 2] {
        [self.motion.apply(point), multiply(&self.rotation, normal)]
    }
}

impl Counterpart for Guide {
    fn probe_on(
        &self,
        face: &ContactFace,
        points: Places<'_>,
        what: Derivatives,
        out: &mut [Contact],
    ) {
        let flat = self.carried(face.point, face.normal);
        let pairs = points.deformed.iter().zip(points.coordinates);
        for (contact, (&point, l)) in out.iter_mut().zip(pairs) {
            let l = &l[..face.corners.len()];
            let curve = face.curve.as_deref();
            let [origin, normal] = curve.map_or(flat, |curve| {
                let area = curve.area_vector(l);
                self.carried(curve.position(l), scale(norm(area).recip(), area))
            });
            contact.distance = self.value - dot(normal, sub(point, origin));
            if what >= Derivatives::Normal {
                contact.normal = scale(-1.0, normal);
            }
            if what >= Derivatives::Curvature {
                contact.curvature = [[0.0; 3]; 3];
            }
        }
    }
}
