//! Sparse Cholesky factor P A P^T = L L^T of a symmetric positive definite
//! matrix, supernodal, through faer.
//!
//! Sequential on purpose: the bits of a factor must not depend on the number
//! of threads. The caller gives the ordering. In single precision factor and
//! solve cost half the time and memory; the error of a solution is then about
//! 1e-7 times the condition of A, which a preconditioner bears.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky, supernodal::SupernodalLltRef,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::traits::RealField;
use faer::{Conj, MatMut, Par, Side};

use super::{DenseMatrix, FactoriseError, Workspace};

/// The lower triangle of a symmetric matrix, column by column, rows ascending.
#[derive(Clone, Debug, Default)]
pub struct LowerColumns {
    /// Start of each column `[size + 1]`.
    pub offsets: Vec<u32>,
    /// Row of each entry.
    pub rows: Vec<u32>,
    /// Entries.
    pub values: Vec<f64>,
}

impl LowerColumns {
    /// Number of columns.
    pub fn size(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }
}

/// Number type of a factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 32 bits.
    Single,
    /// 64 bits.
    Double,
}

/// A number that factors are made of.
trait Scalar: RealField + Copy {
    fn of(value: f64) -> Self;
    fn double(self) -> f64;
}

impl Scalar for f32 {
    fn of(value: f64) -> Self {
        value as Self
    }

    fn double(self) -> f64 {
        self.into()
    }
}

impl Scalar for f64 {
    fn of(value: f64) -> Self {
        value
    }

    fn double(self) -> f64 {
        self
    }
}

/// A factor that solves.
#[derive(Debug)]
pub struct SparseCholesky {
    symbolic: SymbolicCholesky<u32>,
    values: Values,
    size: usize,
}

#[derive(Debug)]
enum Values {
    Single(Vec<f32>),
    Double(Vec<f64>),
}

impl SparseCholesky {
    /// Factorises `matrix` in the order `new_to_old` `[size]`.
    ///
    /// # Errors
    /// [`FactoriseError`] when a pivot is not positive or memory is short.
    pub fn new(
        matrix: &LowerColumns,
        new_to_old: &[u32],
        precision: Precision,
    ) -> Result<Self, FactoriseError> {
        let size = matrix.size();
        let mut old_to_new = vec![0_u32; size];
        for (new, &old) in new_to_old.iter().enumerate() {
            old_to_new[old as usize] = new as u32;
        }
        let order = PermRef::new_checked(new_to_old, &old_to_new, size);
        Self::ordered(matrix, SymmetricOrdering::Custom(order), precision)
    }

    /// Factorises `matrix` in an order of approximately least degree, which asks for no
    /// coordinates (P. Amestoy, T. Davis and I. Duff, SIAM J. Matrix Anal. 17, 1996).
    ///
    /// # Errors
    /// As those of [`Self::new`].
    pub fn by_least_degree(
        matrix: &LowerColumns,
        precision: Precision,
    ) -> Result<Self, FactoriseError> {
        Self::ordered(matrix, SymmetricOrdering::Amd, precision)
    }

    fn ordered(
        matrix: &LowerColumns,
        order: SymmetricOrdering<'_, u32>,
        precision: Precision,
    ) -> Result<Self, FactoriseError> {
        let size = matrix.size();
        let pattern =
            SymbolicSparseColMatRef::new_checked(size, size, &matrix.offsets, None, &matrix.rows);
        let symbolic = factorize_symbolic_cholesky(
            pattern,
            Side::Lower,
            order,
            CholeskySymbolicParams {
                supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
                ..Default::default()
            },
        )
        .map_err(|_| FactoriseError::OutOfMemory)?;
        let values = match precision {
            Precision::Single => {
                let entries: Vec<f32> = matrix.values.iter().map(|&entry| entry as f32).collect();
                Values::Single(factorise(&symbolic, pattern, &entries)?)
            }
            Precision::Double => Values::Double(factorise(&symbolic, pattern, &matrix.values)?),
        };
        Ok(Self {
            symbolic,
            values,
            size,
        })
    }

    /// Solves `A X = B` in place for `count` right-hand sides, column by column.
    pub fn solve(&self, right_hand_sides: &mut [f64], count: usize, work: &mut Workspace) {
        match &self.values {
            Values::Single(values) => {
                let mut single = work.scratch_f32(right_hand_sides.len());
                for (single, b) in single.iter_mut().zip(right_hand_sides.iter()) {
                    *single = *b as f32;
                }
                self.solve_with(values, &mut single, count, work);
                for (x, single) in right_hand_sides.iter_mut().zip(&single) {
                    *x = (*single).into();
                }
                work.give_f32(single);
            }
            Values::Double(values) => self.solve_with(values, right_hand_sides, count, work),
        }
    }

    fn solve_with<T: Scalar>(
        &self,
        values: &[T],
        right_hand_sides: &mut [T],
        count: usize,
        work: &mut Workspace,
    ) {
        let scratch = self.symbolic.solve_in_place_scratch::<T>(count, Par::Seq);
        let mut memory = work.memory(scratch.unaligned_bytes_required());
        LltRef::<u32, T>::new(&self.symbolic, values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(right_hand_sides, self.size, count),
            Par::Seq,
            MemStack::new_any(&mut memory),
        );
        work.give_memory(memory);
    }

    /// The lower triangular trailing block of L: its last `count` rows and
    /// columns, in the factor's order.
    pub fn trailing_block(&self, count: usize) -> DenseMatrix {
        match &self.values {
            Values::Single(values) => self.trailing_block_of(values, count),
            Values::Double(values) => self.trailing_block_of(values, count),
        }
    }

    fn trailing_block_of<T: Scalar>(&self, values: &[T], count: usize) -> DenseMatrix {
        let first = self.size - count;
        let mut block = DenseMatrix::zeros(count, count);
        let SymbolicCholeskyRaw::Supernodal(symbolic) = self.symbolic.raw() else {
            return block;
        };
        let factor = SupernodalLltRef::<u32, T>::new(symbolic, values);
        for index in 0..symbolic.n_supernodes() {
            let supernode = factor.supernode(index);
            let start = supernode.start();
            let width = supernode.val().ncols();
            for column in first.saturating_sub(start).min(width)..width {
                let values = supernode.val().col(column);
                let rows = (start..start + width)
                    .chain(supernode.pattern().iter().map(|&row| row as usize));
                for (position, row) in rows.enumerate() {
                    if row >= start + column {
                        *block.at_mut(row - first, start + column - first) =
                            values[position].double();
                    }
                }
            }
        }
        block
    }

    /// Bytes held by the values.
    pub fn bytes(&self) -> u64 {
        match &self.values {
            Values::Single(values) => size_of_val(values.as_slice()) as u64,
            Values::Double(values) => size_of_val(values.as_slice()) as u64,
        }
    }
}

fn factorise<T: Scalar>(
    symbolic: &SymbolicCholesky<u32>,
    pattern: SymbolicSparseColMatRef<'_, u32>,
    entries: &[T],
) -> Result<Vec<T>, FactoriseError> {
    let mut values = Vec::new();
    values
        .try_reserve_exact(symbolic.len_val())
        .map_err(|_| FactoriseError::OutOfMemory)?;
    values.resize(symbolic.len_val(), T::of(0.0));
    let scratch = symbolic.factorize_numeric_llt_scratch::<T>(Par::Seq, Default::default());
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| FactoriseError::OutOfMemory)?;
    symbolic
        .factorize_numeric_llt(
            &mut values,
            SparseColMatRef::new(pattern, entries),
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        )
        .map_err(|_| FactoriseError::NotPositiveDefinite)?;
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five-point Laplacian on an n by n grid.
    fn laplacian(n: usize) -> LowerColumns {
        let mut matrix = LowerColumns {
            offsets: vec![0],
            ..LowerColumns::default()
        };
        for column in 0..n * n {
            let mut push = |row: usize, value: f64| {
                matrix.rows.push(row as u32);
                matrix.values.push(value);
            };
            push(column, 4.0);
            if column % n + 1 < n {
                push(column + 1, -1.0);
            }
            if column + n < n * n {
                push(column + n, -1.0);
            }
            matrix.offsets.push(matrix.rows.len() as u32);
        }
        matrix
    }

    fn product(matrix: &LowerColumns, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for column in 0..matrix.size() {
            for k in matrix.offsets[column] as usize..matrix.offsets[column + 1] as usize {
                let row = matrix.rows[k] as usize;
                y[row] += matrix.values[k] * x[column];
                if row != column {
                    y[column] += matrix.values[k] * x[row];
                }
            }
        }
        y
    }

    #[test]
    fn a_factor_solves_several_right_hand_sides() {
        let matrix = laplacian(9);
        let order: Vec<u32> = (0..81).rev().collect();
        let factor =
            SparseCholesky::new(&matrix, &order, Precision::Double).expect("positive definite");
        let x = super::super::vector::reproducible_noise(162);
        let mut b = product(&matrix, &x[..81]);
        b.extend(product(&matrix, &x[81..]));
        factor.solve(&mut b, 2, &mut Workspace::new());
        for (value, exact) in b.iter().zip(&x) {
            assert!((value - exact).abs() < 1e-12);
        }
    }

    #[test]
    fn a_factor_in_single_precision_solves_to_its_rounding() {
        let matrix = laplacian(9);
        let order: Vec<u32> = (0..81).rev().collect();
        let factor =
            SparseCholesky::new(&matrix, &order, Precision::Single).expect("positive definite");
        let x = super::super::vector::reproducible_noise(81);
        let mut b = product(&matrix, &x);
        factor.solve(&mut b, 1, &mut Workspace::new());
        for (value, exact) in b.iter().zip(&x) {
            assert!((value - exact).abs() < 1e-5);
        }
        let double = SparseCholesky::new(&matrix, &order, Precision::Double).expect("as above");
        assert_eq!(2 * factor.bytes(), double.bytes());
    }

    #[test]
    fn the_trailing_block_gives_the_inverse_on_the_last_unknowns() {
        let matrix = laplacian(7);
        let last = [3_u32, 4, 24, 40];
        let order: Vec<u32> = (0..49).filter(|i| !last.contains(i)).chain(last).collect();
        let factor =
            SparseCholesky::new(&matrix, &order, Precision::Double).expect("positive definite");
        let inverse = factor.trailing_block(4).inverse_of_product();
        for (j, &column) in last.iter().enumerate() {
            let mut unit = vec![0.0; 49];
            unit[column as usize] = 1.0;
            factor.solve(&mut unit, 1, &mut Workspace::new());
            for (i, &row) in last.iter().enumerate() {
                assert!((inverse.at(i, j) - unit[row as usize]).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        let mut matrix = laplacian(3);
        matrix.values[0] = -4.0;
        let order: Vec<u32> = (0..9).collect();
        assert!(matches!(
            SparseCholesky::new(&matrix, &order, Precision::Double),
            Err(FactoriseError::NotPositiveDefinite)
        ));
    }
}
