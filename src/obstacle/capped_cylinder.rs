//! A circular cylinder between two points, its rims rounded: a rounded corner in the section.
//!
//! ```text
//! q = (r - (R - s), |z| - (L / 2 - s)),   d = corner(q) - s
//! ```
//!
//! R the radius, L the length, s the rounding, z from the middle. R and L are those of the
//! rounded body; s = R = L / 2 is a ball.

use super::corner::corner;
use super::revolution::{Revolved, Section, SectionContact, Stand};
use super::{ObstacleError, check_length, check_point, check_rounding};
use crate::geometry::vector3::{add, norm, scale, sub};

/// Section of a capped cylinder about its middle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Capped {
    radius: f64,
    half_length: f64,
    rounding: f64,
}

/// The cylinder from `from` to `to` `[3]`; reference point is `from`.
///
/// # Errors
/// A number is not finite, the points are one, the radius is not above zero, or the rounding
/// is larger than the radius or half the length.
pub(super) fn capped_cylinder(
    (from, to): ([f64; 3], [f64; 3]),
    (radius, rounding): (f64, f64),
) -> Result<Revolved<Capped>, ObstacleError> {
    check_point("from", from)?;
    let along = sub(check_point("to", to)?, from);
    let half_length = 0.5 * norm(along);
    if half_length == 0.0 {
        return Err(ObstacleError::ZeroLength { parameter: "to" });
    }
    let radius = check_length("radius", radius)?;
    let section = Capped {
        radius,
        half_length,
        rounding: check_rounding(rounding, radius.min(half_length))?,
    };
    let stand = Stand {
        origin: add(from, scale(0.5, along)),
        axis: along,
        reference: from,
        place: "from",
        size: radius,
    };
    Revolved::new(section, stand)
}

impl Section for Capped {
    fn contact(&self, radius: f64, height: f64) -> SectionContact {
        let s = self.rounding;
        let beyond = [
            radius - (self.radius - s),
            height.abs() - (self.half_length - s),
        ];
        let found = corner(beyond, s);
        let [n_r, n_z] = found.normal;
        SectionContact {
            distance: found.distance,
            normal: [n_r, n_z * 1.0_f64.copysign(height)],
            curvature: found.curvature,
        }
    }

    fn inner_circle(&self) -> Option<([f64; 2], f64)> {
        Some(([0.0; 2], self.radius.min(self.half_length)))
    }

    fn sharpest_radius(&self) -> f64 {
        self.rounding
    }

    fn is_smooth(&self) -> bool {
        false
    }

    fn is_symmetric(&self) -> bool {
        self.half_length >= self.radius
    }
}
