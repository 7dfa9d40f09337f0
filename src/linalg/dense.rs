//! Small dense matrices, column by column, their Cholesky and LU factors.

use faer::linalg::solvers::{DenseSolveCore, Llt, PartialPivLu, Solve};
use faer::{MatMut, MatRef, Side};

use super::FactoriseError;

/// A dense matrix, column-major.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DenseMatrix {
    rows: usize,
    columns: usize,
    values: Vec<f64>,
}

/// Columns of a matrix that are worked on together.
struct Panel {
    columns: std::ops::Range<usize>,
    /// Row above which they are zero.
    top: usize,
}

impl DenseMatrix {
    /// A zero matrix.
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self {
            rows,
            columns,
            values: vec![0.0; rows * columns],
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// One column `[rows]`.
    pub fn column(&self, column: usize) -> &[f64] {
        &self.values[column * self.rows..(column + 1) * self.rows]
    }

    /// One column `[rows]`.
    pub fn column_mut(&mut self, column: usize) -> &mut [f64] {
        &mut self.values[column * self.rows..(column + 1) * self.rows]
    }

    /// One entry.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.values[column * self.rows + row]
    }

    /// One entry.
    pub fn at_mut(&mut self, row: usize, column: usize) -> &mut f64 {
        &mut self.values[column * self.rows + row]
    }

    /// `y = A x`.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for (column, &factor) in x.iter().enumerate() {
            if factor != 0.0 {
                for (sum, value) in y.iter_mut().zip(self.column(column)) {
                    *sum += factor * value;
                }
            }
        }
    }

    /// Rows and columns `selected` as a matrix of their own.
    pub fn principal(&self, selected: &[usize]) -> Self {
        let mut part = Self::zeros(selected.len(), selected.len());
        for (j, &column) in selected.iter().enumerate() {
            let from = self.column(column);
            for (value, &row) in part.column_mut(j).iter_mut().zip(selected) {
                *value = from[row];
            }
        }
        part
    }

    /// Copies the lower triangle of a square matrix to the upper one.
    pub fn mirror(&mut self) {
        /// Rows and columns that are copied together, so that both stay in the cache.
        const BLOCK: usize = 32;
        for first in (0..self.columns).step_by(BLOCK) {
            for from in (first..self.rows).step_by(BLOCK) {
                for column in first..(first + BLOCK).min(self.columns) {
                    for row in from.max(column + 1)..(from + BLOCK).min(self.rows) {
                        *self.at_mut(column, row) = self.at(row, column);
                    }
                }
            }
        }
    }

    /// `(L L^T)^-1` for a lower triangular `self = L`.
    pub fn inverse_of_product(&self) -> Self {
        let mut identity = Self::zeros(self.rows, self.rows);
        (0..self.rows).for_each(|i| *identity.at_mut(i, i) = 1.0);
        self.inverse_of_product_on(identity)
    }

    /// `R^T (L L^T)^-1 R` for a lower triangular `self = L`; spends `right`.
    pub fn inverse_of_product_on(&self, mut right: Self) -> Self {
        let size = right.columns;
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(
            self.view(),
            MatMut::from_column_major_slice_mut(&mut right.values, self.rows, size),
            faer::Par::Seq,
        );
        let mut product = Self::zeros(size, size);
        faer::linalg::matmul::matmul(
            MatMut::from_column_major_slice_mut(&mut product.values, size, size),
            faer::Accum::Replace,
            right.view().transpose(),
            right.view(),
            1.0,
            faer::Par::Seq,
        );
        product
    }

    /// The same for a `right` with about as many columns as rows, zero above a staircase:
    /// what it leaves zero is not computed. Cost: two ninths of the above.
    pub fn inverse_of_product_below(&self, mut right: Self) -> Self {
        let panels = right.panels();
        for panel in &panels {
            let top = panel.top;
            let columns = &mut right.values[panel.columns.start * self.rows..];
            let columns = &mut columns[..panel.columns.len() * self.rows];
            let columns =
                MatMut::from_column_major_slice_mut(columns, self.rows, panel.columns.len());
            faer::linalg::triangular_solve::solve_lower_triangular_in_place(
                self.view()
                    .submatrix(top, top, self.rows - top, self.rows - top),
                columns.subrows_mut(top, self.rows - top),
                faer::Par::Seq,
            );
        }
        right.product_below(&panels)
    }

    /// Columns in groups, with the row above which they are zero.
    fn panels(&self) -> Vec<Panel> {
        /// Columns that are worked on together.
        const WIDTH: usize = 64;
        let top = |column: usize| {
            let entries = self.column(column).iter();
            entries.take_while(|&&value| value == 0.0).count()
        };
        let panel = |start: usize| {
            let columns = start..(start + WIDTH).min(self.columns);
            let top = columns.clone().map(top).min().unwrap_or(self.rows);
            Panel { columns, top }
        };
        (0..self.columns).step_by(WIDTH).map(panel).collect()
    }

    /// `A^T A`, without the rows above which its panels are zero.
    fn product_below(&self, panels: &[Panel]) -> Self {
        let size = self.columns;
        let mut product = Self::zeros(size, size);
        for (at, panel) in panels.iter().enumerate() {
            let width = panel.columns.len();
            let columns = &mut product.values[panel.columns.start * size..];
            let columns = &mut columns[..width * size];
            for below in &panels[at..] {
                let top = below.top.max(panel.top);
                let part = |panel: &Panel| {
                    let (start, width) = (panel.columns.start, panel.columns.len());
                    self.view().submatrix(top, start, self.rows - top, width)
                };
                let target = MatMut::from_column_major_slice_mut(columns, size, width);
                faer::linalg::matmul::matmul(
                    target.subrows_mut(below.columns.start, below.columns.len()),
                    faer::Accum::Replace,
                    part(below).transpose(),
                    part(panel),
                    1.0,
                    faer::Par::Seq,
                );
            }
        }
        product.mirror();
        product
    }

    /// `A^T B` `[columns, columns of B]`.
    pub fn transposed_times(&self, other: &Self) -> Self {
        let mut product = Self::zeros(self.columns, other.columns);
        faer::linalg::matmul::matmul(
            MatMut::from_column_major_slice_mut(&mut product.values, self.columns, other.columns),
            faer::Accum::Replace,
            self.view().transpose(),
            other.view(),
            1.0,
            faer::Par::Seq,
        );
        product
    }

    /// All entries, column by column.
    pub fn entries_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        8 * self.values.len() as u64
    }

    /// Multiplies every entry.
    pub fn scale(&mut self, factor: f64) {
        super::vector::scale(&mut self.values, factor);
    }

    pub(super) fn view(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.values, self.rows, self.columns)
    }
}

/// Cholesky factor of a small symmetric positive definite matrix.
#[derive(Clone, Debug)]
pub struct DenseCholesky {
    size: usize,
    factor: Option<Llt<f64>>,
}

impl DenseCholesky {
    /// Factorises; reads the lower triangle.
    ///
    /// # Errors
    /// When the matrix is not positive definite.
    pub fn new(matrix: &DenseMatrix) -> Result<Self, FactoriseError> {
        let factor = match matrix.rows {
            0 => None,
            _ => Some(
                Llt::new(matrix.view(), Side::Lower)
                    .map_err(|_| FactoriseError::NotPositiveDefinite)?,
            ),
        };
        Ok(Self {
            size: matrix.rows,
            factor,
        })
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The inverse. Cost: twice that of the factor.
    pub fn inverse(&self) -> DenseMatrix {
        let mut inverse = DenseMatrix::zeros(self.size, self.size);
        if let Some(factor) = &self.factor {
            let values = factor.inverse();
            for column in 0..self.size {
                let entries = inverse.column_mut(column).iter_mut().enumerate();
                entries.for_each(|(row, entry)| *entry = values[(row, column)]);
            }
        }
        inverse
    }

    /// Solves in place.
    pub fn solve(&self, right_hand_side: &mut [f64]) {
        if let Some(factor) = &self.factor {
            factor.solve_in_place(MatMut::from_column_major_slice_mut(
                right_hand_side,
                self.size,
                1,
            ));
        }
    }

    /// Solves for every column in place.
    pub fn solve_all(&self, right_hand_sides: &mut DenseMatrix) {
        if let Some(factor) = &self.factor {
            let columns = right_hand_sides.columns;
            factor.solve_in_place(MatMut::from_column_major_slice_mut(
                &mut right_hand_sides.values,
                self.size,
                columns,
            ));
        }
    }
}

/// LU factor of a small matrix, rows interchanged.
#[derive(Clone, Debug)]
pub struct DenseLu {
    size: usize,
    factor: Option<PartialPivLu<f64>>,
}

impl DenseLu {
    /// Factorises.
    ///
    /// # Errors
    /// When the matrix is singular or holds what is no number.
    pub fn new(matrix: &DenseMatrix) -> Result<Self, FactoriseError> {
        let factor = (matrix.rows > 0).then(|| PartialPivLu::new(matrix.view()));
        if let Some(factor) = &factor {
            let upper = factor.U();
            let is_regular = |i: usize| upper[(i, i)] != 0.0 && upper[(i, i)].is_finite();
            if !(0..matrix.rows).all(is_regular) {
                return Err(FactoriseError::NotPositiveDefinite);
            }
        }
        Ok(Self {
            size: matrix.rows,
            factor,
        })
    }

    /// Solves in place.
    pub fn solve(&self, right_hand_side: &mut [f64]) {
        if let Some(factor) = &self.factor {
            let right = MatMut::from_column_major_slice_mut(right_hand_side, self.size, 1);
            factor.solve_in_place(right);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> DenseMatrix {
        let mut matrix = DenseMatrix::zeros(3, 3);
        let rows = [[4.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 2.0]];
        for (i, row) in rows.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                *matrix.at_mut(i, j) = *value;
            }
        }
        matrix
    }

    #[test]
    fn a_staircase_gives_the_same_inverse_as_all_rows() {
        const SIZE: usize = 150;
        let mut lower = DenseMatrix::zeros(SIZE, SIZE);
        let mut right = DenseMatrix::zeros(SIZE, SIZE - 10);
        for column in 0..SIZE {
            for row in column..SIZE {
                let value = ((row * 7 + column * 13) % 11) as f64 / 11.0 - 0.4;
                *lower.at_mut(row, column) = if row == column { 4.0 } else { value / 20.0 };
                if column < SIZE - 10 && row < column + 3 {
                    *right.at_mut(row, column) = 1.0 + value;
                }
            }
        }
        let all = lower.inverse_of_product_on(right.clone());
        let below = lower.inverse_of_product_below(right);
        for column in 0..SIZE - 10 {
            let pairs = all.column(column).iter().zip(below.column(column));
            pairs.for_each(|(a, b)| assert!((a - b).abs() < 1e-14, "{a} {b}"));
        }
    }

    #[test]
    fn a_factor_solves_its_own_product() {
        let matrix = example();
        let factor = DenseCholesky::new(&matrix).expect("positive definite");
        let mut y = [0.0; 3];
        matrix.multiply(&[1.0, -2.0, 3.0], &mut y);
        factor.solve(&mut y);
        for (value, exact) in y.iter().zip([1.0, -2.0, 3.0]) {
            assert!((value - exact).abs() < 1e-14);
        }
    }

    #[test]
    fn an_unsymmetric_matrix_is_solved_and_a_singular_one_refused() {
        let mut matrix = example();
        *matrix.at_mut(0, 2) = -7.0;
        let mut y = [0.0; 3];
        matrix.multiply(&[1.0, -2.0, 3.0], &mut y);
        DenseLu::new(&matrix).expect("regular").solve(&mut y);
        for (value, exact) in y.iter().zip([1.0, -2.0, 3.0]) {
            assert!((value - exact).abs() < 1e-14);
        }
        assert!(DenseLu::new(&DenseMatrix::zeros(2, 2)).is_err());
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        let mut matrix = example();
        *matrix.at_mut(2, 2) = -1.0;
        assert!(DenseCholesky::new(&matrix).is_err());
    }

    #[test]
    fn the_inverse_of_a_factor_product_inverts_it() {
        let mut lower = DenseMatrix::zeros(2, 2);
        *lower.at_mut(0, 0) = 2.0;
        *lower.at_mut(1, 0) = 1.0;
        *lower.at_mut(1, 1) = 3.0;
        // L L^T = [4 2; 2 10], inverse = [10 -2; -2 4] / 36.
        let inverse = lower.inverse_of_product();
        assert!((inverse.at(0, 0) - 10.0 / 36.0).abs() < 1e-15);
        assert!((inverse.at(0, 1) + 2.0 / 36.0).abs() < 1e-15);
        assert!((inverse.at(1, 1) - 4.0 / 36.0).abs() < 1e-15);
    }
}
