//! Bodies of revolution: a distance d(r, z) in the half-plane of radius r >= 0 and height z
//! along an axis a, turned around the axis.
//!
//! ```text
//! n = n_r e_r + n_z a,   H = k t (x) t + n_r / r  e_f (x) e_f,   t = -n_z e_r + n_r a
//! ```
//!
//! with n, k normal and curvature of the section, e_f = a x e_r. On the axis n_r is zero where
//! the surface is smooth there, and H turns about n as k does; elsewhere points of the axis are
//! as far from a whole circle of the surface, and a fixed direction is taken for e_r, H being
//! zero. Lengths are the shape's. Cost: some 60 flops a point.

use std::fmt;

use super::{
    Ball, Contact, Derivatives, Obstacle, ObstacleError, check_direction, check_point, is_central,
    orthogonal,
};
use crate::geometry::vector3::{add, cross, dot, norm, scale, sub};

/// What a section is to a point of its half-plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SectionContact {
    /// Signed distance, above zero outside.
    pub(super) distance: f64,
    /// Its gradient `[radial, along the axis]`, unit.
    pub(super) normal: [f64; 2],
    /// Its second derivative along the surface, one over length.
    pub(super) curvature: f64,
}

/// A distance in the half-plane of an axis.
pub(super) trait Section: fmt::Debug + Send + Sync {
    /// What the section is to the point at `radius` >= 0 and `height`.
    fn contact(&self, radius: f64, height: f64) -> SectionContact;

    /// Place `[radius, height]` and radius of the largest circle inside, if there is one.
    fn inner_circle(&self) -> Option<([f64; 2], f64)>;

    /// Smallest radius of curvature of its convex parts; zero at corners.
    fn sharpest_radius(&self) -> f64;

    /// Whether its curvature is continuous.
    fn is_smooth(&self) -> bool;

    /// Whether the section is the same upside down, about its origin.
    fn is_symmetric(&self) -> bool;
}

/// A section turned around an axis through its origin.
#[derive(Clone, Debug)]
pub(super) struct Revolved<S> {
    section: S,
    /// Where the section's origin lies, length.
    origin: [f64; 3],
    /// Unit vector along increasing heights.
    axis: [f64; 3],
    /// The radial direction on the axis, unit.
    sideways: [f64; 3],
    reference: [f64; 3],
    /// Name of the parameter that gives the place.
    place: &'static str,
    /// A length of the shape, above zero.
    size: f64,
}

/// Where a section stands in space.
pub(super) struct Stand {
    /// Where the section's origin lies.
    pub(super) origin: [f64; 3],
    /// Along increasing heights, of any length.
    pub(super) axis: [f64; 3],
    /// Reference point.
    pub(super) reference: [f64; 3],
    /// Name of the parameter that gives the place.
    pub(super) place: &'static str,
    /// A length of the shape, above zero.
    pub(super) size: f64,
}

impl<S: Section> Revolved<S> {
    /// # Errors
    /// The place is not finite, or the axis has no direction.
    pub(super) fn new(section: S, stand: Stand) -> Result<Self, ObstacleError> {
        check_point(stand.place, stand.reference)?;
        let axis = check_direction("axis", stand.axis)?;
        Ok(Self {
            section,
            origin: check_point(stand.place, stand.origin)?,
            axis,
            sideways: orthogonal(axis),
            reference: stand.reference,
            place: stand.place,
            size: stand.size,
        })
    }

    fn contact(&self, point: [f64; 3], derivatives: Derivatives, contact: &mut Contact) {
        let offset = sub(point, self.origin);
        let height = dot(offset, self.axis);
        let across = sub(offset, scale(height, self.axis));
        let radius = norm(across);
        let section = self.section.contact(radius, height);
        contact.distance = section.distance;
        if derivatives == Derivatives::Gap {
            return;
        }
        let is_central = is_central(radius, self.size);
        let radial = if is_central {
            self.sideways
        } else {
            scale(1.0 / radius, across)
        };
        let [n_r, n_z] = section.normal;
        contact.normal = add(scale(n_r, radial), scale(n_z, self.axis));
        if derivatives == Derivatives::Curvature {
            let around = if !is_central {
                n_r / radius
            } else if n_r == 0.0 {
                section.curvature
            } else {
                0.0
            };
            let along = if is_central && n_r != 0.0 {
                0.0
            } else {
                section.curvature
            };
            let tangent = add(scale(-n_z, radial), scale(n_r, self.axis));
            let ring = cross(self.axis, radial);
            for (i, row) in contact.curvature.iter_mut().enumerate() {
                for (j, entry) in row.iter_mut().enumerate() {
                    *entry = along * tangent[i] * tangent[j] + around * ring[i] * ring[j];
                }
            }
        }
    }
}

impl<S: Section> Obstacle for Revolved<S> {
    fn probe(&self, points: &[[f64; 3]], derivatives: Derivatives, out: &mut [Contact]) {
        for (contact, &point) in out.iter_mut().zip(points) {
            self.contact(point, derivatives, contact);
        }
    }

    fn reference_point(&self) -> [f64; 3] {
        self.reference
    }

    fn is_flat(&self) -> bool {
        false
    }

    fn inner_ball(&self) -> Option<Ball> {
        let ([radius, height], size) = self.section.inner_circle()?;
        let place = add(scale(radius, self.sideways), scale(height, self.axis));
        Some(Ball {
            centre: add(self.origin, place),
            radius: size,
        })
    }

    fn sharpest_radius(&self) -> Option<f64> {
        Some(self.section.sharpest_radius())
    }

    fn is_smooth(&self) -> bool {
        self.section.is_smooth()
    }

    fn is_closed(&self) -> bool {
        true
    }

    fn lies_in_plane(&self) -> Result<(), ObstacleError> {
        let outside = |parameter| Err(ObstacleError::OutOfPlane { parameter });
        let [x, y, z] = self.axis;
        match (z == 0.0, x == 0.0 && y == 0.0) {
            _ if self.origin[2] != 0.0 => outside(self.place),
            (true, _) => Ok(()),
            (false, true) if self.section.is_symmetric() => Ok(()),
            _ => outside("axis"),
        }
    }
}
