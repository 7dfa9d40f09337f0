//! Signed distances at the nodes of a grid in space: above zero outside the tool, below inside.

use super::checks::Bends;
use super::error::GridError;
use super::foot::{Frame, Level};
use super::lattice::Lattice;
use super::spline::{Beyond, Jet, Spline};
use crate::geometry::vector3::{add, norm, scale, sub};
use crate::obstacle::Ball;

/// Steps along the gradient from the middle of a cell to the surface in it.
const STEPS: usize = 3;
/// Slopes that a distance to first order may have on the surface.
const SLOPES: std::ops::RangeInclusive<f64> = 0.5..=2.0;

/// A tool given by signed distances, whose surface is where their spline is zero.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceGrid {
    spline: Spline<3>,
    deepest: Ball,
    sharpest: Option<f64>,
    is_enclosed: bool,
}

impl DistanceGrid {
    /// The tool of `values`, one a node.
    ///
    /// # Errors
    /// What is no grid, has no surface in it, does not change as distances do on the surface,
    /// or bends there within less than three spacings.
    pub fn new(lattice: Lattice<3>, values: &[f64]) -> Result<Self, GridError> {
        lattice.check(values)?;
        let spline = Spline::new(lattice, values, Beyond::Clamped);
        spline.check(values)?;
        let deepest = deepest(&lattice, values)?;
        let sharpest = sharpest(&spline, values)?;
        Ok(Self {
            deepest,
            sharpest,
            is_enclosed: is_enclosed(&lattice, values),
            spline,
        })
    }

    /// The nodes.
    pub fn lattice(&self) -> &Lattice<3> {
        self.spline.lattice()
    }

    /// What the values determine and which determines them, one a node and more.
    pub fn coefficients(&self) -> &[f64] {
        self.spline.coefficients()
    }

    /// The ball of the deepest node.
    pub(super) fn deepest(&self) -> Ball {
        self.deepest
    }

    /// Smallest radius of the convex parts.
    pub(super) fn sharpest(&self) -> Option<f64> {
        self.sharpest
    }

    /// Whether the border of the grid is outside the tool.
    pub fn is_enclosed(&self) -> bool {
        self.is_enclosed
    }

    /// The nearest place of the grid.
    pub(super) fn nearest_place(&self, x: [f64; 3]) -> [f64; 3] {
        let (low, high) = (self.lattice().origin, self.lattice().end());
        std::array::from_fn(|k| x[k].max(low[k]).min(high[k]))
    }
}

impl Level for DistanceGrid {
    fn jet(&self, place: [f64; 3]) -> Jet<3> {
        self.spline.jet(place)
    }

    fn cell(&self) -> f64 {
        self.lattice().finest()
    }
}

/// The node with the lowest value.
fn deepest(lattice: &Lattice<3>, values: &[f64]) -> Result<Ball, GridError> {
    let lower = |least: (usize, f64), (index, value): (usize, &f64)| {
        if *value < least.1 {
            (index, *value)
        } else {
            least
        }
    };
    let (index, value) = values.iter().enumerate().fold((0, 0.0), lower);
    if value >= 0.0 {
        return Err(GridError::NoSurface { side: "below" });
    }
    if values.iter().all(|value| *value <= 0.0) {
        return Err(GridError::NoSurface { side: "above" });
    }
    Ok(Ball {
        centre: lattice.place(lattice.node(index).map(|i| i as f64)),
        radius: -value,
    })
}

/// Whether all values of the border are above zero.
fn is_enclosed(lattice: &Lattice<3>, values: &[f64]) -> bool {
    let is_border = |node: [usize; 3]| {
        let at_end = |k: usize| node[k] == 0 || node[k] + 1 == lattice.counts[k];
        (0..3).any(at_end)
    };
    let mut border =
        (values.iter().enumerate()).filter(|(index, _)| is_border(lattice.node(*index)));
    border.all(|(_, value)| *value > 0.0)
}

/// Checks the surface in all cells with values of both signs, for its smallest convex radius.
fn sharpest(spline: &Spline<3>, values: &[f64]) -> Result<Option<f64>, GridError> {
    let lattice = spline.lattice();
    let spacing = lattice.coarsest();
    let mut bends = Bends::default();
    for index in 0..values.len() {
        let node = lattice.node(index);
        if !is_crossed(lattice, values, node) {
            continue;
        }
        let middle = lattice.place(node.map(|i| i as f64 + 0.5));
        let frame = on_surface(spline, middle, lattice.finest());
        let frame = frame.filter(|frame| SLOPES.contains(&frame.slope));
        let Some(frame) = frame else {
            return Err(GridError::NotADistance {
                node: node.to_vec(),
                slope: norm(spline.jet(middle).gradient),
            });
        };
        bends = bends.join(&frame, (&node, spacing))?;
    }
    let size = norm(sub(lattice.end(), lattice.origin));
    Ok(bends.sharpest_radius(size))
}

/// Whether the cell that begins at `node` has corners of both signs.
fn is_crossed(lattice: &Lattice<3>, values: &[f64], node: [usize; 3]) -> bool {
    let [_, ny, nz] = lattice.counts;
    if (0..3).any(|k| node[k] + 1 >= lattice.counts[k]) {
        return false;
    }
    let first = (node[0] * ny + node[1]) * nz + node[2];
    let corner = |i: usize| values[first + (i & 1) + (i >> 1 & 1) * nz + (i >> 2) * ny * nz];
    let inside = (0..8).filter(|&i| corner(i) < 0.0).count();
    inside > 0 && inside < 8
}

/// The frame of the surface near `place`.
fn on_surface(spline: &Spline<3>, place: [f64; 3], cell: f64) -> Option<Frame> {
    let mut y = place;
    for _ in 0..STEPS {
        let jet = spline.jet(y);
        let frame = Frame::new(&jet)?;
        let rise = (-jet.value / frame.slope).clamp(-cell, cell);
        y = add(y, scale(rise, frame.normal));
    }
    Frame::new(&spline.jet(y))
}
