//! The parabola of a channel: product over the axes along the surface of 4 s (1 - s),
//! s = (x - low) / (high - low).

use super::Faults;
use crate::mesh::Mesh;

/// Thickness of a flat surface relative to the mesh.
const FLAT: f64 = 1e-9;

/// One at the middle of a box of mesh coordinates, zero on its rim.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Parabola {
    low: [f64; 3],
    high: [f64; 3],
    /// Axes along the surface.
    axes: Vec<usize>,
}

impl Parabola {
    /// Value at a point of the mesh.
    pub(crate) fn at(&self, point: [f64; 3]) -> f64 {
        let along = |&axis: &usize| {
            let s = (point[axis] - self.low[axis]) / (self.high[axis] - self.low[axis]);
            4.0 * s * (1.0 - s)
        };
        self.axes.iter().map(along).product()
    }

    /// Over flat `facets`; adds a fault of the key `path` where they are not.
    pub(crate) fn over(
        mesh: &Mesh,
        facets: &[u32],
        path: &str,
        faults: &mut Faults,
    ) -> Option<Self> {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &facet in facets {
            for &vertex in mesh.facet(facet as usize) {
                let point = mesh.coordinates()[vertex as usize];
                for i in 0..3 {
                    low[i] = low[i].min(point[i]);
                    high[i] = high[i].max(point[i]);
                }
            }
        }
        let dimension = mesh.cell_kind().dimension();
        let is_wide = |axis: &usize| high[*axis] - low[*axis] > FLAT * mesh.extent();
        let axes: Vec<usize> = (0..dimension).filter(is_wide).collect();
        if axes.len() + 1 != dimension {
            let message = "`parabolic` needs one flat surface perpendicular to an axis";
            faults.add(path, message);
            return None;
        }
        Some(Self { low, high, axes })
    }
}
