//! Shape of the cells: the mean ratio, 1 for the regular cell and 0 for a flat one.
//!
//! η = 12 (3V)^(2/3) / Σ l² for tetrahedra, η = 4√3 A / Σ l² for triangles
//! (Liu and Joe 1994). One pass over the cells, no memory.

use super::cell::{CellKind, ScaledMeasures};

/// Mean-ratio quality of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Smallest mean ratio of a cell, in (0, 1]; one is the regular simplex.
    pub minimum: f64,
    /// Arithmetic mean of the cells' mean ratios, in (0, 1].
    pub mean: f64,
    /// The first cell with the smallest ratio, 0-based in upload order.
    pub worst_cell: u32,
}

/// Mean ratio of one cell of positive measure.
pub fn mean_ratio(kind: CellKind, corners: &[[f64; 3]; 4]) -> f64 {
    ratio(kind, &kind.scaled_measures(corners))
}

/// Mean ratio of one cell from its scaled sizes: one for the regular simplex, zero
/// without volume.
fn ratio(kind: CellKind, sizes: &ScaledMeasures) -> f64 {
    let numerator = match kind {
        CellKind::Triangle => 4.0 * 3_f64.sqrt() * sizes.measure,
        CellKind::Tetrahedron => 12.0 * (3.0 * sizes.measure).cbrt().powi(2),
    };
    numerator / sizes.sum_of_squares
}

/// The quality of the cells added so far.
#[derive(Debug)]
pub(super) struct Mean {
    /// Smallest ratio so far.
    minimum: f64,
    /// Sum of the ratios so far, in the order of the cells.
    sum: f64,
    /// Cell with the smallest ratio so far, 0-based.
    worst_cell: u32,
    /// Number of cells so far.
    count: u32,
}

impl Default for Mean {
    fn default() -> Self {
        Self {
            minimum: 1.0,
            sum: 0.0,
            worst_cell: 0,
            count: 0,
        }
    }
}

impl Mean {
    /// Adds the next cell.
    pub(super) fn add(&mut self, kind: CellKind, sizes: &ScaledMeasures) {
        let ratio = ratio(kind, sizes).min(1.0);
        if ratio < self.minimum {
            self.minimum = ratio;
            self.worst_cell = self.count;
        }
        self.sum += ratio;
        self.count += 1;
    }

    /// The minimum is 1 where there are no cells.
    pub(super) fn finish(self) -> Quality {
        Quality {
            minimum: self.minimum,
            mean: self.sum / f64::from(self.count.max(1)),
            worst_cell: self.worst_cell,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNER: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn regular_cells_have_ratio_one_at_every_size() {
        let height = 0.75_f64.sqrt();
        for size in [1e-200, 1.0, 1e200] {
            let triangle = [
                [0.0; 3],
                [size, 0.0, 0.0],
                [0.5 * size, height * size, 0.0],
                [0.0; 3],
            ];
            assert!((mean_ratio(CellKind::Triangle, &triangle) - 1.0).abs() < 1e-14);
            let regular = [
                [1.0, 1.0, 1.0],
                [-1.0, 1.0, -1.0],
                [1.0, -1.0, -1.0],
                [-1.0, -1.0, 1.0],
            ];
            let tetrahedron = regular.map(|corner| corner.map(|component: f64| size * component));
            assert!((mean_ratio(CellKind::Tetrahedron, &tetrahedron) - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn corner_of_a_cube_has_its_known_ratio() {
        // V = 1/6 and Σ l² = 9.
        let expected = 12.0 * 0.5_f64.powf(2.0 / 3.0) / 9.0;
        assert!((mean_ratio(CellKind::Tetrahedron, &CORNER) - expected).abs() < 1e-14);
    }

    #[test]
    fn worst_cell_is_the_first_with_the_smallest_ratio() {
        let mut flat = CORNER;
        flat[3][2] = 0.01;
        let cells = [CORNER, flat, flat, CORNER];
        let kind = CellKind::Tetrahedron;
        let mut mean = Mean::default();
        for corners in cells {
            mean.add(kind, &kind.scaled_measures(&corners));
        }
        let quality = mean.finish();
        assert_eq!(quality.worst_cell, 1);
        assert!(quality.minimum < 0.2 && quality.mean > quality.minimum && quality.mean < 1.0);
    }
}
