//! A box along the axes, its edges and corners rounded: d = corner(|x - c| - (b - s)) - s.
//!
//! b half the sizes of the rounded body, s the rounding, c the centre. H is that of the nearest
//! edge (a cylinder) or corner (a ball), zero at faces. Exact; d has one normal on the surface
//! where s > 0, and its curvature jumps there.

use super::corner::corner;
use super::{
    Ball, Contact, Derivatives, Obstacle, ObstacleError, check_length, check_plane, check_point,
    check_rounding,
};

/// A rounded box with its centre as reference point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Centre and reference point, length.
    centre: [f64; 3],
    /// Half the sizes, rounding included, above zero.
    half_sizes: [f64; 3],
    /// Radius of edges and corners, at least zero.
    rounding: f64,
}

impl Cuboid {
    /// `centre` `[3]`, `half_sizes` `[3]` and `rounding`, lengths.
    ///
    /// # Errors
    /// A number is not finite, a size is not above zero, or the rounding is larger than one.
    pub fn new(
        centre: [f64; 3],
        half_sizes: [f64; 3],
        rounding: f64,
    ) -> Result<Self, ObstacleError> {
        check_point("half_sizes", half_sizes)?;
        for size in half_sizes {
            check_length("half_sizes", size)?;
        }
        let least = half_sizes.into_iter().fold(f64::INFINITY, f64::min);
        Ok(Self {
            centre: check_point("centre", centre)?,
            half_sizes,
            rounding: check_rounding(rounding, least)?,
        })
    }

    fn least_half_size(&self) -> f64 {
        self.half_sizes.into_iter().fold(f64::INFINITY, f64::min)
    }
}

impl Obstacle for Cuboid {
    fn probe(&self, points: &[[f64; 3]], derivatives: Derivatives, out: &mut [Contact]) {
        for (contact, &point) in out.iter_mut().zip(points) {
            let offset: [f64; 3] = std::array::from_fn(|i| point[i] - self.centre[i]);
            let beyond =
                std::array::from_fn(|i| offset[i].abs() - (self.half_sizes[i] - self.rounding));
            let found = corner::<3>(beyond, self.rounding);
            contact.distance = found.distance;
            if derivatives == Derivatives::Gap {
                continue;
            }
            contact.normal = std::array::from_fn(|i| found.normal[i] * 1.0_f64.copysign(offset[i]));
            if derivatives == Derivatives::Curvature {
                contact.curvature = std::array::from_fn(|i| {
                    std::array::from_fn(|j| {
                        let is_free = beyond[i] > 0.0 && beyond[j] > 0.0;
                        let identity = if i == j { 1.0 } else { 0.0 };
                        let bend = identity - contact.normal[i] * contact.normal[j];
                        if is_free { found.curvature * bend } else { 0.0 }
                    })
                });
            }
        }
    }

    fn reference_point(&self) -> [f64; 3] {
        self.centre
    }

    fn is_flat(&self) -> bool {
        false
    }

    fn inner_ball(&self) -> Option<Ball> {
        Some(Ball {
            centre: self.centre,
            radius: self.least_half_size(),
        })
    }

    fn sharpest_radius(&self) -> Option<f64> {
        Some(self.rounding)
    }

    fn is_smooth(&self) -> bool {
        false
    }

    fn is_closed(&self) -> bool {
        true
    }

    /// Where the faces across the plane are nearer than those along it, they are what points
    /// inside would be pushed to.
    fn lies_in_plane(&self) -> Result<(), ObstacleError> {
        check_plane("centre", self.centre[2])?;
        if self.half_sizes[2] > self.half_sizes[0].min(self.half_sizes[1]) {
            Ok(())
        } else {
            Err(ObstacleError::OutOfPlane {
                parameter: "half_sizes",
            })
        }
    }
}
