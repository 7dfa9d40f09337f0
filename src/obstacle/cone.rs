//! An infinite circular cone, its tip rounded by an inscribed ball.
//!
//! ```text
//! w = (r, z - s / sin A),   f = w . (sin A, cos A)
//! d = w . (cos A, -sin A) - s  where f >= 0,   |w| - s  elsewhere
//! ```
//!
//! z from the sharp apex into the cone, A half the angle between opposite sides, s the ball's
//! radius, w the offset from its centre. The two parts meet with one normal.

use std::f64::consts::FRAC_PI_2;

use super::revolution::{Revolved, Section, SectionContact, Stand};
use super::{ObstacleError, check_point, check_rounding};

/// Section of a cone about its sharp apex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tip {
    sine: f64,
    cosine: f64,
    rounding: f64,
}

/// The cone with its sharp `apex` `[3]`, the reference point, `axis` `[3]` pointing into it and
/// half `angle`, radians.
///
/// # Errors
/// A number is not finite, the axis is zero, the angle is not between zero and a right angle,
/// or the rounding is negative.
pub(super) fn cone(
    (apex, axis): ([f64; 3], [f64; 3]),
    (angle, rounding): (f64, f64),
) -> Result<Revolved<Tip>, ObstacleError> {
    check_point("apex", apex)?;
    if !(angle > 0.0 && angle < FRAC_PI_2) {
        return Err(if angle.is_finite() {
            ObstacleError::NotAnAngle {
                parameter: "angle",
                value: angle,
            }
        } else {
            ObstacleError::NotFinite { parameter: "angle" }
        });
    }
    let (sine, cosine) = angle.sin_cos();
    let section = Tip {
        sine,
        cosine,
        rounding: check_rounding(rounding, f64::INFINITY)?,
    };
    let stand = Stand {
        origin: apex,
        axis,
        reference: apex,
        place: "apex",
        size: if rounding > 0.0 { rounding } else { 1.0 },
    };
    Revolved::new(section, stand)
}

impl Section for Tip {
    fn contact(&self, radius: f64, height: f64) -> SectionContact {
        let (sine, cosine) = (self.sine, self.cosine);
        let offset = [radius, height - self.rounding / sine];
        let length = offset[0].hypot(offset[1]);
        if offset[0] * sine + offset[1] * cosine >= 0.0 || length == 0.0 {
            return SectionContact {
                distance: offset[0] * cosine - offset[1] * sine - self.rounding,
                normal: [cosine, -sine],
                curvature: 0.0,
            };
        }
        SectionContact {
            distance: length - self.rounding,
            normal: offset.map(|x| x / length),
            curvature: 1.0 / length,
        }
    }

    fn inner_circle(&self) -> Option<([f64; 2], f64)> {
        None
    }

    fn sharpest_radius(&self) -> f64 {
        self.rounding
    }

    fn is_smooth(&self) -> bool {
        false
    }

    fn is_symmetric(&self) -> bool {
        false
    }
}
