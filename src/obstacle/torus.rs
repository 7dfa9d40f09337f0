//! A torus: a circle of radius s around (R, 0) in the section.
//!
//! ```text
//! d = |(r - R, z)| - s,   n = (r - R, z) / |(r - R, z)|,   k = 1 / |(r - R, z)|
//! ```
//!
//! R the radius of the circle that the tube follows, s < R the tube's. At the centre of the
//! tube the normal is radial.

use super::revolution::{Revolved, Section, SectionContact, Stand};
use super::{ObstacleError, check_length, is_central};

/// Section of a torus about its centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tube {
    radius: f64,
    tube_radius: f64,
}

/// The torus around `centre` `[3]`, its reference point, with `axis` `[3]` of any length.
///
/// # Errors
/// A number is not finite, the axis is zero, a radius is not above zero, or the tube is not
/// thinner than its circle.
pub(super) fn torus(
    (centre, axis): ([f64; 3], [f64; 3]),
    (radius, tube_radius): (f64, f64),
) -> Result<Revolved<Tube>, ObstacleError> {
    let radius = check_length("radius", radius)?;
    let tube_radius = check_length("tube_radius", tube_radius)?;
    if tube_radius >= radius {
        return Err(ObstacleError::TooLarge {
            parameter: "tube_radius",
            value: tube_radius,
            limit: radius,
        });
    }
    let section = Tube {
        radius,
        tube_radius,
    };
    let stand = Stand {
        origin: centre,
        axis,
        reference: centre,
        place: "centre",
        size: radius,
    };
    Revolved::new(section, stand)
}

impl Section for Tube {
    fn contact(&self, radius: f64, height: f64) -> SectionContact {
        let offset = [radius - self.radius, height];
        let length = offset[0].hypot(offset[1]);
        let distance = length - self.tube_radius;
        if is_central(length, self.tube_radius) {
            return SectionContact {
                distance,
                normal: [1.0, 0.0],
                curvature: 0.0,
            };
        }
        SectionContact {
            distance,
            normal: offset.map(|x| x / length),
            curvature: 1.0 / length,
        }
    }

    fn inner_circle(&self) -> Option<([f64; 2], f64)> {
        Some(([self.radius, 0.0], self.tube_radius))
    }

    fn sharpest_radius(&self) -> f64 {
        self.tube_radius
    }

    fn is_smooth(&self) -> bool {
        true
    }

    fn is_symmetric(&self) -> bool {
        true
    }
}
