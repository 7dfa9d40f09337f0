//! Intervals of contact of a plane body or a section: stretches of faces in contact with their
//! ends, widths and forces.
//!
//! Lengths are those of the deformed, scaled body. Cost: the rule on the faces in contact.

use super::deformed::Deformed;
use super::portion::Measured;
use super::stretches::{Stretch, polygon};
use super::surface::ContactSurface;
use crate::element::quadrature::Rule;
use crate::geometry::vector3::add;

/// Contact without a break along the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactInterval {
    /// Where it begins and ends in the deformed body `[2][3]`, in units of the scaled body.
    pub ends: [[f64; 3]; 2],
    /// Length of the deformed surface between, in units of the scaled body.
    pub width: f64,
    /// Force of the contact pressure on the body `[3]`, non-dimensional: per thickness, or of the
    /// full turn about an axis.
    pub force: [f64; 3],
}

/// The interval of a stretch; `forces` are those of all faces.
pub(super) fn interval(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    (stretch, forces): (&Stretch, &[[f64; 3]]),
    rule: &Rule,
) -> ContactInterval {
    let mut interval = ContactInterval::default();
    let mut is_first = true;
    for &(face, share) in stretch {
        interval.force = add(interval.force, forces[face]);
        if share[0] >= share[1] {
            // Nothing of it is covered.
            continue;
        }
        let measured = Measured::of(body, &surface.faces[face]);
        let part = polygon(share);
        let [from, to] = part.map(|point| measured.at(&point));
        if is_first {
            interval.ends[0] = from;
            is_first = false;
        }
        interval.ends[1] = to;
        interval.width += measured.length(&part, rule);
    }
    interval
}
