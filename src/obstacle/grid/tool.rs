//! Grids as obstacles. Reference point is the origin of their coordinates.

use std::fmt;
use std::sync::Arc;

use super::distance::DistanceGrid;
use super::foot::{Frame, Level, nearest};
use super::height::HeightField;
use crate::geometry::vector3::{add, dot, norm, normalised, scale, sub};
use crate::obstacle::{Ball, Contact, Derivatives, Obstacle, ObstacleError};

/// Slopes that a distance is corrected for, where its nearest point is not found: smaller ones are
/// those of places between two sides, where it does not grow with 1 / slope.
const SLOPES: (f64, f64) = (1.0, 2.0);
/// Distance, in cells, within which the sign of a point may be rounding.
const AT_SURFACE: f64 = 1e-6;

/// A grid, its lengths divided by one.
#[derive(Clone, Debug)]
pub struct Sampled<T> {
    grid: Arc<T>,
    length: f64,
}

impl<T> Sampled<T> {
    /// The tool of `grid` with all lengths divided by `length`, above zero.
    pub fn new(grid: &Arc<T>, length: f64) -> Self {
        let grid = Arc::clone(grid);
        Self { grid, length }
    }
}

/// What differs between grids.
trait Tool: fmt::Debug + Send + Sync {
    /// Distance, normal and curvature in the grid's own lengths.
    fn contact(&self, x: [f64; 3]) -> Contact;
    fn inner_ball(&self) -> Option<Ball>;
    fn sharpest_radius(&self) -> Option<f64>;
    fn is_closed(&self) -> bool;
}

/// The distance to first order, F / |grad F|, where there is no nearest point to be found.
fn first_order(level: &impl Level, x: [f64; 3]) -> Contact {
    let jet = level.jet(x);
    let frame = Frame::new(&jet);
    let slope = frame.as_ref().map_or(1.0, |frame| frame.slope);
    Contact {
        distance: jet.value / slope.clamp(SLOPES.0, SLOPES.1),
        normal: frame.map_or([0.0, 0.0, 1.0], |frame| frame.normal),
        curvature: [[0.0; 3]; 3],
    }
}

/// Whether a distance is on the side that F says.
fn is_on_side(contact: &Contact, value: f64, cell: f64) -> bool {
    contact.distance * value >= 0.0 || contact.distance.abs() <= AT_SURFACE * cell
}

impl Tool for HeightField {
    fn contact(&self, x: [f64; 3]) -> Contact {
        let found = nearest(self, x, self.start(x)).map(|(contact, _)| contact);
        found
            .filter(|contact| is_on_side(contact, self.jet(x).value, self.cell()))
            .unwrap_or_else(|| first_order(self, x))
    }

    fn inner_ball(&self) -> Option<Ball> {
        None
    }

    fn sharpest_radius(&self) -> Option<f64> {
        self.sharpest()
    }

    /// What lies above it is a solid as well.
    fn is_closed(&self) -> bool {
        true
    }
}

impl Tool for DistanceGrid {
    /// Where the surface leaves the grid, the distance beyond is that to the grid and the value
    /// at its nearest place.
    fn contact(&self, x: [f64; 3]) -> Contact {
        let place = self.nearest_place(x);
        let gap = norm(sub(x, place));
        let near = first_order(self, place);
        let start = sub(place, scale(near.distance, near.normal));
        let is_in_grid =
            |y: [f64; 3]| norm(sub(y, self.nearest_place(y))) <= AT_SURFACE * self.cell();
        let found = nearest(self, x, start).filter(|(_, y)| is_in_grid(*y));
        let sign = near.distance;
        match found {
            Some((contact, _)) if gap > 0.0 || is_on_side(&contact, sign, self.cell()) => contact,
            _ if gap > 0.0 => beyond(near, sub(x, place)),
            _ => near,
        }
    }

    fn inner_ball(&self) -> Option<Ball> {
        Some(self.deepest())
    }

    fn sharpest_radius(&self) -> Option<f64> {
        self.sharpest()
    }

    fn is_closed(&self) -> bool {
        self.is_enclosed()
    }
}

/// Beyond a grid by `offset` from the place with contact `near`.
fn beyond(near: Contact, offset: [f64; 3]) -> Contact {
    let gap = norm(offset);
    let outwards = scale(1.0 / gap, offset);
    // Only what of the slope lies along the border changes beyond it.
    let along = sub(near.normal, scale(dot(near.normal, outwards), outwards));
    Contact {
        distance: near.distance + gap,
        normal: normalised(add(outwards, along)).unwrap_or(outwards),
        curvature: [[0.0; 3]; 3],
    }
}

impl<T: Tool> Obstacle for Sampled<T> {
    fn probe(&self, points: &[[f64; 3]], derivatives: Derivatives, out: &mut [Contact]) {
        for (out, &point) in out.iter_mut().zip(points) {
            let contact = self.grid.contact(scale(self.length, point));
            out.distance = contact.distance / self.length;
            if derivatives >= Derivatives::Normal {
                out.normal = contact.normal;
            }
            if derivatives >= Derivatives::Curvature {
                out.curvature = contact.curvature.map(|row| scale(self.length, row));
            }
        }
    }

    fn reference_point(&self) -> [f64; 3] {
        [0.0; 3]
    }

    fn is_flat(&self) -> bool {
        false
    }

    fn inner_ball(&self) -> Option<Ball> {
        self.grid.inner_ball().map(|ball| Ball {
            centre: scale(1.0 / self.length, ball.centre),
            radius: ball.radius / self.length,
        })
    }

    fn sharpest_radius(&self) -> Option<f64> {
        let radius = self.grid.sharpest_radius();
        radius.map(|radius| radius / self.length)
    }

    fn is_smooth(&self) -> bool {
        true
    }

    fn is_closed(&self) -> bool {
        self.grid.is_closed()
    }

    fn has_exact_distances(&self) -> bool {
        false
    }

    fn lies_in_plane(&self) -> Result<(), ObstacleError> {
        Err(ObstacleError::OutOfPlane { parameter: "kind" })
    }
}
