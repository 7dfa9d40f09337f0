//! Shape of the cells: the mean ratio, 1 for the regular cell and 0 for a flat one.
//!
//! η = 12 (3V)^(2/3) / Σ l² for tetrahedra, η = 4√3 A / Σ l² for triangles
//! (Liu and Joe 1994). One pass over the cells, no memory.

use super::cell::CellKind;

/// Mean-ratio quality of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Smallest mean ratio, in (0, 1].
    pub minimum: f64,
    /// Arithmetic mean of the cells' mean ratios, in (0, 1].
    pub mean: f64,
    /// The first cell with the smallest ratio, 0-based in upload order.
    pub worst_cell: u32,
}

/// Mean ratio of one cell of positive measure.
pub fn mean_ratio(kind: CellKind, corners: &[[f64; 3]; 4]) -> f64 {
    let sizes = kind.scaled_measures(corners);
    let numerator = match kind {
        CellKind::Triangle => 4.0 * 3_f64.sqrt() * sizes.measure,
        CellKind::Tetrahedron => 12.0 * (3.0 * sizes.measure).cbrt().powi(2),
    };
    numerator / sizes.sum_of_squares
}

/// Quality over the corners of all cells; the minimum is 1 where there are none.
pub(crate) fn quality(kind: CellKind, cells: impl Iterator<Item = [[f64; 3]; 4]>) -> Quality {
    let mut result = Quality {
        minimum: 1.0,
        mean: 0.0,
        worst_cell: 0,
    };
    let mut count = 0_u32;
    for corners in cells {
        let ratio = mean_ratio(kind, &corners).min(1.0);
        if ratio < result.minimum {
            result.minimum = ratio;
            result.worst_cell = count;
        }
        result.mean += ratio;
        count += 1;
    }
    result.mean /= f64::from(count.max(1));
    result
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
        let quality = quality(CellKind::Tetrahedron, cells.into_iter());
        assert_eq!(quality.worst_cell, 1);
        assert!(quality.minimum < 0.2 && quality.mean > quality.minimum && quality.mean < 1.0);
    }
}
