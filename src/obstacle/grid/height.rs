//! Heights z at the nodes of a grid over the plane of x and y: the tool lies below them.

use super::checks::Bends;
use super::error::GridError;
use super::foot::{Frame, Level};
use super::lattice::Lattice;
use super::spline::{Beyond, Jet, Spline};
use crate::geometry::vector3::norm;

/// Places an axis, on each side of a point, at which its nearest point is looked for.
const SAMPLES: i32 = 2;

/// A tool given by heights. Beyond the grid it is as high as the border, which it reaches over
/// three cells.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    spline: Spline<2>,
    sharpest: Option<f64>,
}

impl HeightField {
    /// The tool of `values`, one a node.
    ///
    /// # Errors
    /// What is no grid, or bends within less than three spacings.
    pub fn new(lattice: Lattice<2>, values: &[f64]) -> Result<Self, GridError> {
        lattice.check(values)?;
        let spline = Spline::new(lattice, values, Beyond::Flat);
        spline.check(values)?;
        let mut tool = Self {
            spline,
            sharpest: None,
        };
        tool.sharpest = tool.smallest_radius()?;
        Ok(tool)
    }

    /// The nodes.
    pub fn lattice(&self) -> &Lattice<2> {
        self.spline.lattice()
    }

    /// What the values determine and which determines them, one a node and more.
    pub fn coefficients(&self) -> &[f64] {
        self.spline.coefficients()
    }

    /// Smallest radius of the convex parts.
    pub(super) fn sharpest(&self) -> Option<f64> {
        self.sharpest
    }

    /// The place of the surface from which the nearest one to `x` is looked for.
    pub(super) fn start(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let on_surface = |x: f64, y: f64| [x, y, self.spline.jet([x, y]).value];
        let below = on_surface(x, y);
        let range = (z - below[2]).abs();
        // Nearer than that nothing bends so much that another place is nearer.
        if range <= self.cell() {
            return below;
        }
        let square = |p: [f64; 3]| (p[0] - x).powi(2) + (p[1] - y).powi(2) + (p[2] - z).powi(2);
        let step = range / f64::from(SAMPLES);
        let sides = -SAMPLES..=SAMPLES;
        let places = sides
            .clone()
            .flat_map(|i| sides.clone().map(move |j| (i, j)));
        places
            .map(|(i, j)| on_surface(x + f64::from(i) * step, y + f64::from(j) * step))
            .fold(below, |best, place| {
                if square(place) < square(best) {
                    place
                } else {
                    best
                }
            })
    }

    /// The curvature of a spline is largest at its nodes.
    fn smallest_radius(&self) -> Result<Option<f64>, GridError> {
        let lattice = self.lattice();
        let spacing = lattice.coarsest();
        let mut bends = Bends::default();
        for index in 0..lattice.nodes()? {
            let node = lattice.node(index);
            let [x, y] = lattice.place(node.map(|i| i as f64));
            let frame = Frame::new(&self.jet([x, y, 0.0]));
            let Some(frame) = frame else {
                let node = node.to_vec();
                return Err(GridError::NotFinite { node });
            };
            bends = bends.join(&frame, (&node, spacing))?;
        }
        let (low, high) = (lattice.origin, lattice.end());
        let size = norm([high[0] - low[0], high[1] - low[1], 0.0]);
        Ok(bends.sharpest_radius(size))
    }
}

impl Level for HeightField {
    fn jet(&self, [x, y, z]: [f64; 3]) -> Jet<3> {
        let height = self.spline.jet([x, y]);
        let ([a, b], [[aa, ab], [_, bb]]) = (height.gradient, height.hessian);
        Jet {
            value: z - height.value,
            gradient: [-a, -b, 1.0],
            hessian: [[-aa, -ab, 0.0], [-ab, -bb, 0.0], [0.0; 3]],
        }
    }

    fn cell(&self) -> f64 {
        self.lattice().finest()
    }
}
