//! Which cell holds a point: a uniform grid of bins over the bounding box, each
//! listing the cells whose boxes meet it.
//!
//! A point belongs to a cell when it lies at most 1e-9 of the mesh's extent
//! beyond any of its facets; of several such cells the lowest index is taken.
//! About one bin per cell; building costs O(n), a query the few cells of a bin.
//! The grid is coarsened where long cells would fill too many bins.

use super::Mesh;
use super::cell::barycentric_gradients;
use crate::geometry::vector3::{dot, norm, sub};

/// How far outside a cell a point may lie, relative to the extent.
const TOLERANCE: f64 = 1e-9;

/// Most list entries per cell before the grid is coarsened.
const ENTRIES_PER_CELL: usize = 64;

/// A point within a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located {
    /// The cell that holds the point, 0-based.
    pub cell: u32,
    /// Barycentric coordinates `[vertices]`, sum 1; as low as −1e-9 of the
    /// extent over the height just outside; unused ones are zero.
    pub barycentric: [f64; 4],
}

/// The bins over one mesh.
#[derive(Debug)]
pub struct Locator {
    /// The bins.
    grid: Grid,
    /// Start of each bin in `cells` `[bins + 1]`.
    starts: Vec<usize>,
    /// Cells whose boxes meet a bin, bin after bin, ascending within one.
    cells: Vec<u32>,
    /// How far outside a cell a point may lie and still count as within, length.
    tolerance: f64,
}

impl Locator {
    /// Sorts the cells of `mesh` into bins.
    pub fn new(mesh: &Mesh) -> Self {
        let tolerance = TOLERANCE * mesh.extent();
        let whole = Bounds::around(mesh.coordinates().iter().copied()).grown(tolerance);
        let mut bins = mesh.cell_count();
        let (grid, counts) = loop {
            let grid = Grid::new(whole, bins);
            match grid.counts(mesh, tolerance) {
                Some(counts) => break (grid, counts),
                None => bins /= 8,
            }
        };
        let starts = offsets(&counts);
        let cells = grid.fill(mesh, tolerance, &starts);
        Self {
            grid,
            starts,
            cells,
            tolerance,
        }
    }

    /// The lowest cell of `mesh` (the one this was made from) that holds
    /// `point` `[3]`; `None` outside the mesh.
    pub fn find(&self, mesh: &Mesh, point: [f64; 3]) -> Option<Located> {
        let bin = self.grid.bin_of(point)?;
        let candidates = &self.cells[self.starts[bin]..self.starts[bin + 1]];
        candidates
            .iter()
            .find_map(|&cell| self.within(mesh, cell, point))
    }

    /// The point within that cell by its barycentric coordinates, or none where one of
    /// them is below zero by more than rounding.
    fn within(&self, mesh: &Mesh, cell: u32, point: [f64; 3]) -> Option<Located> {
        let kind = mesh.cell_kind();
        let corners = mesh.corners(cell as usize);
        let gradients = barycentric_gradients(kind, &corners);
        let mut barycentric = [0.0; 4];
        for vertex in 0..kind.vertices() {
            // Measured from a vertex of the opposite facet, where it is zero.
            let base = corners[kind.facets()[vertex][0]];
            let value = dot(gradients[vertex], sub(point, base));
            let lowest = -self.tolerance * norm(gradients[vertex]);
            if value < lowest {
                return None;
            }
            barycentric[vertex] = value;
        }
        Some(Located { cell, barycentric })
    }
}

/// An axis-parallel box.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    /// Least coordinate along each axis `[3]`, length.
    low: [f64; 3],
    /// Largest coordinate along each axis `[3]`, length.
    high: [f64; 3],
}

impl Bounds {
    /// The smallest box around all points.
    fn around(points: impl Iterator<Item = [f64; 3]>) -> Self {
        let mut bounds = Self {
            low: [f64::INFINITY; 3],
            high: [f64::NEG_INFINITY; 3],
        };
        for point in points {
            for axis in 0..3 {
                bounds.low[axis] = bounds.low[axis].min(point[axis]);
                bounds.high[axis] = bounds.high[axis].max(point[axis]);
            }
        }
        bounds
    }

    /// The smallest box around one cell.
    fn of_cell(mesh: &Mesh, cell: usize) -> Self {
        let corners = mesh.corners(cell);
        Self::around(corners.into_iter().take(mesh.cell_kind().vertices()))
    }

    /// The box made larger by `margin`, a length, on every side.
    fn grown(mut self, margin: f64) -> Self {
        for axis in 0..3 {
            self.low[axis] -= margin;
            self.high[axis] += margin;
        }
        self
    }
}

/// Equal bins over a box.
#[derive(Debug)]
struct Grid {
    /// The box that the bins fill.
    bounds: Bounds,
    /// Number of bins along each axis `[3]`, at least one.
    shape: [usize; 3],
}

impl Grid {
    /// About `bins` nearly cubic bins.
    fn new(bounds: Bounds, bins: usize) -> Self {
        let sides = [0, 1, 2].map(|axis| bounds.high[axis] - bounds.low[axis]);
        let longest = sides.iter().copied().fold(0.0, f64::max);
        // Flat directions count as one bin, which leaves the others more.
        let wide = sides.map(|side| side > 1e-3 * longest);
        let product: f64 = (0..3)
            .filter(|&axis| wide[axis])
            .map(|axis| sides[axis] / longest)
            .product();
        let dimension = wide.iter().filter(|&&flag| flag).count().max(1);
        let per_longest = (bins as f64 / product).powf(1.0 / dimension as f64);
        let along = |axis: usize| {
            let wanted = (per_longest * sides[axis] / longest).floor();
            // A conversion from float saturates, NaN gives zero.
            (wanted as usize).clamp(1, bins.max(1))
        };
        let shape = [0, 1, 2].map(|axis| if wide[axis] { along(axis) } else { 1 });
        Self { bounds, shape }
    }

    /// Number of bins in all.
    fn bin_count(&self) -> usize {
        self.shape.iter().product()
    }

    /// Position along an axis; points outside go to the nearest bin.
    fn position(&self, axis: usize, coordinate: f64) -> usize {
        let (low, high) = (self.bounds.low[axis], self.bounds.high[axis]);
        let fraction = (coordinate - low) / (high - low);
        let position = (fraction * self.shape[axis] as f64) as usize;
        position.min(self.shape[axis] - 1)
    }

    /// The bin of a point, or none outside the box.
    fn bin_of(&self, point: [f64; 3]) -> Option<usize> {
        let inside =
            |axis: usize| (self.bounds.low[axis]..=self.bounds.high[axis]).contains(&point[axis]);
        if !(0..3).all(inside) {
            return None;
        }
        let [x, y, z] = [0, 1, 2].map(|axis| self.position(axis, point[axis]));
        Some(self.bin(x, y, z))
    }

    /// Number of a bin by its position along the axes; x runs fastest.
    fn bin(&self, x: usize, y: usize, z: usize) -> usize {
        (z * self.shape[1] + y) * self.shape[0] + x
    }

    /// First and last position along each axis that a box meets.
    fn span(&self, bounds: Bounds) -> [(usize, usize); 3] {
        [0, 1, 2].map(|axis| {
            let first = self.position(axis, bounds.low[axis]);
            (first, self.position(axis, bounds.high[axis]))
        })
    }

    /// Calls `visit` with every bin that meets `bounds`.
    fn for_each_bin(&self, bounds: Bounds, mut visit: impl FnMut(usize)) {
        let [along_x, along_y, along_z] = self.span(bounds);
        for z in along_z.0..=along_z.1 {
            for y in along_y.0..=along_y.1 {
                for x in along_x.0..=along_x.1 {
                    visit(self.bin(x, y, z));
                }
            }
        }
    }

    /// Entries in each bin; `None` if there are too many in all.
    fn counts(&self, mesh: &Mesh, margin: f64) -> Option<Vec<usize>> {
        let limit = ENTRIES_PER_CELL * mesh.cell_count();
        let mut counts = vec![0; self.bin_count()];
        let mut total = 0_usize;
        for cell in 0..mesh.cell_count() {
            let bounds = Bounds::of_cell(mesh, cell).grown(margin);
            let spans = self.span(bounds).map(|(first, last)| last - first + 1);
            total = total.saturating_add(spans.iter().product());
            if total > limit {
                return None;
            }
            self.for_each_bin(bounds, |bin| counts[bin] += 1);
        }
        Some(counts)
    }

    /// Cells of each bin, ascending.
    fn fill(&self, mesh: &Mesh, margin: f64, starts: &[usize]) -> Vec<u32> {
        let mut next = starts.to_vec();
        let mut cells = vec![0; starts[self.bin_count()]];
        for cell in 0..mesh.cell_count() {
            let bounds = Bounds::of_cell(mesh, cell).grown(margin);
            self.for_each_bin(bounds, |bin| {
                cells[next[bin]] = cell as u32;
                next[bin] += 1;
            });
        }
        cells
    }
}

/// Running sums `[counts + 1]`, from zero.
fn offsets(counts: &[usize]) -> Vec<usize> {
    let mut starts = Vec::with_capacity(counts.len() + 1);
    let mut total = 0;
    starts.push(total);
    for count in counts {
        total += count;
        starts.push(total);
    }
    starts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::samples::{cube, rectangle};

    #[test]
    fn points_inside_are_reproduced_by_their_coordinates() {
        let mesh = cube(4);
        let locator = Locator::new(&mesh);
        for index in 0..200_u32 {
            let fraction = |step: f64| (f64::from(index) * step).fract();
            let point = [fraction(0.618_034), fraction(0.754_878), fraction(0.569_84)];
            let located = locator.find(&mesh, point).expect("inside the cube");
            let corners = mesh.corners(located.cell as usize);
            for axis in 0..3 {
                let terms = located.barycentric.iter().zip(corners);
                let value: f64 = terms.map(|(weight, corner)| weight * corner[axis]).sum();
                assert!((value - point[axis]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn shared_points_belong_to_the_lowest_cell() {
        let mesh = cube(3);
        let locator = Locator::new(&mesh);
        for (vertex, &point) in mesh.coordinates().iter().enumerate() {
            let located = locator.find(&mesh, point).expect("a vertex");
            let lowest = mesh
                .cells()
                .chunks(4)
                .position(|cell| cell.contains(&(vertex as u32)));
            assert_eq!(Some(located.cell as usize), lowest);
        }
    }

    #[test]
    fn tolerance_is_a_billionth_of_the_extent() {
        let mesh = cube(2);
        let locator = Locator::new(&mesh);
        assert!(locator.find(&mesh, [0.4, 0.3, 1.0 + 0.9e-9]).is_some());
        assert!(locator.find(&mesh, [0.4, 0.3, 1.0 + 1.1e-9]).is_none());
        assert!(locator.find(&mesh, [-5.0, 0.3, 0.2]).is_none());
        assert!(locator.find(&mesh, [f64::NAN, 0.3, 0.2]).is_none());
    }

    #[test]
    fn plane_meshes_hold_points_of_their_plane() {
        let mesh = rectangle(5, 3);
        let locator = Locator::new(&mesh);
        let located = locator.find(&mesh, [0.31, 0.77, 0.0]).expect("inside");
        assert!((located.barycentric.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        assert!(locator.find(&mesh, [0.31, 0.77, 0.1]).is_none());
    }

    #[test]
    fn entries_stay_bounded_for_stretched_meshes() {
        let mesh = rectangle(1, 2000);
        let locator = Locator::new(&mesh);
        assert!(locator.cells.len() <= ENTRIES_PER_CELL * mesh.cell_count());
        assert!(locator.find(&mesh, [0.9, 0.5, 0.0]).is_some());
    }
}
