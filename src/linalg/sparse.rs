//! Sparse matrices by rows: masses and contact couplings.
//!
//! Applying costs 12 bytes and two flops per entry. The transposed product is
//! sequential; it serves matrices with few rows.

use super::{LinearOperator, Workspace};
use crate::parallel::{self, Pieces};

/// Rows shorter than this in total are not worth a second thread.
const PARALLEL_ROWS: usize = 4096;
/// Rows of a piece.
const ROWS: usize = 1024;

/// A sparse matrix, row by row, columns ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SparseRows {
    columns: usize,
    offsets: Vec<usize>,
    indices: Vec<u32>,
    values: Vec<f64>,
}

/// Collects entries row by row.
#[derive(Clone, Debug)]
pub struct SparseRowsBuilder {
    matrix: SparseRows,
}

impl SparseRowsBuilder {
    /// A matrix of `columns` columns and no rows yet.
    pub fn new(columns: usize) -> Self {
        Self {
            matrix: SparseRows {
                columns,
                offsets: vec![0],
                ..SparseRows::default()
            },
        }
    }

    /// Appends what is larger than `share` of the largest entry of a dense row.
    pub fn push_dense(&mut self, row: &[f64], share: f64) {
        let bound = share * row.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (column, &value) in (0..).zip(row) {
            if value.abs() > bound {
                self.matrix.indices.push(column);
                self.matrix.values.push(value);
            }
        }
        self.matrix.offsets.push(self.matrix.indices.len());
    }

    /// Appends a row; entries of the same column are summed in the given order.
    pub fn push_row(&mut self, entries: &mut [(u32, f64)]) {
        entries.sort_by_key(|entry| entry.0);
        let start = self.matrix.indices.len();
        for &(column, value) in entries.iter() {
            match self.matrix.indices[start..].last() {
                Some(&last) if last == column => {
                    if let Some(sum) = self.matrix.values.last_mut() {
                        *sum += value;
                    }
                }
                _ => {
                    self.matrix.indices.push(column);
                    self.matrix.values.push(value);
                }
            }
        }
        self.matrix.offsets.push(self.matrix.indices.len());
    }

    /// The finished matrix.
    pub fn finish(self) -> SparseRows {
        self.matrix
    }
}

impl SparseRows {
    /// Sums element matrices: `cells` lists `nodes` row and column indices per
    /// element, `entry(cell, i, j)` gives the values. Square, `size` rows.
    pub fn assemble(
        size: usize,
        cells: &[u32],
        nodes: usize,
        entry: impl Fn(usize, usize, usize) -> f64,
    ) -> Self {
        let mut incident: Vec<Vec<(u32, u8)>> = vec![Vec::new(); size];
        for (cell, vertices) in cells.chunks_exact(nodes).enumerate() {
            for (local, &vertex) in vertices.iter().enumerate() {
                incident[vertex as usize].push((cell as u32, local as u8));
            }
        }
        let mut builder = SparseRowsBuilder::new(size);
        let mut row = Vec::new();
        for touching in &incident {
            row.clear();
            for &(cell, i) in touching {
                let cell = cell as usize;
                for j in 0..nodes {
                    row.push((cells[cell * nodes + j], entry(cell, i as usize, j)));
                }
            }
            builder.push_row(&mut row);
        }
        builder.finish()
    }

    /// Column indices and values of one row.
    pub fn row(&self, row: usize) -> (&[u32], &[f64]) {
        let range = self.offsets[row]..self.offsets[row + 1];
        (&self.indices[range.clone()], &self.values[range])
    }

    /// The sum of two matrices of the same shape.
    pub fn plus(&self, other: &Self) -> Self {
        self.plus_multiple(1.0, other)
    }

    /// This matrix plus `factor` times another of the same shape.
    pub fn plus_multiple(&self, factor: f64, other: &Self) -> Self {
        let mut builder = SparseRowsBuilder::new(self.columns);
        let mut entries = Vec::new();
        for row in 0..self.offsets.len() - 1 {
            entries.clear();
            for (one, (columns, values)) in [(1.0, self.row(row)), (factor, other.row(row))] {
                let values = values.iter().map(|value| one * value);
                entries.extend(columns.iter().copied().zip(values));
            }
            builder.push_row(&mut entries);
        }
        builder.finish()
    }

    /// The transposed matrix.
    pub fn transposed(&self) -> Self {
        let mut columns: Vec<Vec<(u32, f64)>> = vec![Vec::new(); self.columns];
        for row in 0..self.offsets.len() - 1 {
            let (indices, values) = self.row(row);
            for (&column, &value) in indices.iter().zip(values) {
                columns[column as usize].push((row as u32, value));
            }
        }
        let mut builder = SparseRowsBuilder::new(self.offsets.len() - 1);
        columns.iter_mut().for_each(|row| builder.push_row(row));
        builder.finish()
    }

    /// Largest absolute value of an entry.
    pub fn largest(&self) -> f64 {
        self.values.iter().fold(0.0, |most, x| most.max(x.abs()))
    }

    /// `factor` times the entries that are larger than `bound`.
    pub fn scaled_above(&self, factor: f64, bound: f64) -> Self {
        let mut builder = SparseRowsBuilder::new(self.columns);
        for row in 0..self.offsets.len() - 1 {
            let (columns, values) = self.row(row);
            let entries = columns.iter().zip(values);
            let kept = entries.filter(|(_, value)| value.abs() > bound);
            let mut kept: Vec<_> = kept.map(|(&c, value)| (c, factor * value)).collect();
            builder.push_row(&mut kept);
        }
        builder.finish()
    }

    /// Those rows, in that order.
    pub fn selected(&self, rows: &[usize]) -> Self {
        let mut builder = SparseRowsBuilder::new(self.columns);
        for &row in rows {
            let (columns, values) = self.row(row);
            let mut entries: Vec<_> = columns
                .iter()
                .copied()
                .zip(values.iter().copied())
                .collect();
            builder.push_row(&mut entries);
        }
        builder.finish()
    }

    /// Multiplies every column by its factor.
    pub fn scale_columns(&mut self, factors: &[f64]) {
        for (value, &column) in self.values.iter_mut().zip(&self.indices) {
            *value *= factors[column as usize];
        }
    }

    /// Adds `factor` times a row to `x`.
    pub fn add_row(&self, row: usize, factor: f64, x: &mut [f64]) {
        let (columns, values) = self.row(row);
        for (&column, value) in columns.iter().zip(values) {
            x[column as usize] += factor * value;
        }
    }

    /// The diagonal of a square matrix.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.rows())
            .map(|row| {
                let (columns, values) = self.row(row);
                let found = columns.binary_search(&(row as u32)).ok();
                found.map_or(0.0, |position| values[position])
            })
            .collect()
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        (8 * self.offsets.len() + 4 * self.indices.len() + 8 * self.values.len()) as u64
    }

    fn for_rows(&self, y: &mut [f64], visit: impl Fn(usize, &mut f64) + Sync) {
        if y.len() < PARALLEL_ROWS {
            y.iter_mut()
                .enumerate()
                .for_each(|(row, value)| visit(row, value));
        } else {
            parallel::each(Pieces::of(y, ROWS), 1, &|piece, y| {
                for (row, value) in (piece * ROWS..).zip(y) {
                    visit(row, value);
                }
            });
        }
    }

    /// Adds `scale y_i` times row i to `x`; rows with zero are not read.
    fn add_rows(&self, scale: f64, y: &[f64], x: &mut [f64]) {
        for (row, &factor) in y.iter().enumerate() {
            if factor == 0.0 {
                continue;
            }
            let (columns, values) = self.row(row);
            for (&column, value) in columns.iter().zip(values) {
                x[column as usize] += scale * factor * value;
            }
        }
    }

    /// Product of one row with `x`.
    pub fn row_product(&self, row: usize, x: &[f64]) -> f64 {
        let (columns, values) = self.row(row);
        columns
            .iter()
            .zip(values)
            .map(|(&column, value)| value * x[column as usize])
            .sum()
    }
}

impl LinearOperator for SparseRows {
    fn rows(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    fn columns(&self) -> usize {
        self.columns
    }

    fn apply(&self, x: &[f64], y: &mut [f64], _work: &mut Workspace) {
        self.for_rows(y, |row, value| *value = self.row_product(row, x));
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], _work: &mut Workspace) {
        x.fill(0.0);
        self.add_rows(1.0, y, x);
    }

    fn subtract_product(&self, x: &[f64], r: &mut [f64], _work: &mut Workspace) {
        self.for_rows(r, |row, value| *value -= self.row_product(row, x));
    }

    fn add_transposed(&self, factor: f64, y: &[f64], x: &mut [f64], _work: &mut Workspace) {
        self.add_rows(factor, y, x);
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // These values are exact.
mod tests {
    use super::*;

    #[test]
    fn a_matrix_of_nothing_has_no_rows() {
        assert_eq!(SparseRows::default().rows(), 0);
        assert_eq!(SparseRowsBuilder::new(0).finish().rows(), 0);
    }

    #[test]
    fn products_match_the_dense_matrix() {
        let mut builder = SparseRowsBuilder::new(3);
        builder.push_row(&mut [(2, 1.0), (0, 2.0), (2, 3.0)]);
        builder.push_row(&mut []);
        let matrix = builder.finish();
        let mut work = Workspace::new();
        let mut y = [9.0; 2];
        matrix.apply(&[1.0, 10.0, 100.0], &mut y, &mut work);
        assert_eq!(y, [402.0, 0.0]);
        let mut x = [9.0; 3];
        matrix.apply_transposed(&[2.0, 5.0], &mut x, &mut work);
        assert_eq!(x, [4.0, 0.0, 8.0]);
    }

    #[test]
    fn a_sum_holds_the_entries_of_both() {
        let matrix = |rows: [&mut [(u32, f64)]; 2]| {
            let mut builder = SparseRowsBuilder::new(3);
            rows.into_iter().for_each(|row| builder.push_row(row));
            builder.finish()
        };
        let a = matrix([&mut [(0, 1.0), (2, 2.0)], &mut []]);
        let b = matrix([&mut [(1, 5.0), (2, 3.0)], &mut [(0, 4.0)]]);
        let sum = matrix([&mut [(0, 1.0), (1, 5.0), (2, 5.0)], &mut [(0, 4.0)]]);
        assert_eq!(a.plus(&b), sum);
        let twice = matrix([&mut [(1, 10.0), (2, 6.0)], &mut [(0, 8.0)]]);
        assert_eq!(a.plus_multiple(-2.0, &b), a.plus_multiple(-1.0, &twice));
    }

    #[test]
    fn the_transposed_matrix_has_columns_for_rows() {
        let mut builder = SparseRowsBuilder::new(3);
        builder.push_row(&mut [(0, 2.0), (2, 4.0)]);
        builder.push_row(&mut [(2, 5.0)]);
        let transposed = builder.finish().transposed();
        assert_eq!(transposed.row(0), (&[0][..], &[2.0][..]));
        assert_eq!(transposed.row(1), (&[][..], &[][..]));
        assert_eq!(transposed.row(2), (&[0, 1][..], &[4.0, 5.0][..]));
        assert_eq!((transposed.rows(), transposed.columns()), (3, 2));
    }

    #[test]
    fn assembly_sums_the_shared_entries() {
        let matrix = SparseRows::assemble(
            3,
            &[0, 1, 1, 2],
            2,
            |_, i, j| {
                if i == j { 2.0 } else { -1.0 }
            },
        );
        assert_eq!(matrix.diagonal(), [2.0, 4.0, 2.0]);
        assert_eq!(matrix.row(1), (&[0, 1, 2][..], &[-1.0, 4.0, -1.0][..]));
    }
}
