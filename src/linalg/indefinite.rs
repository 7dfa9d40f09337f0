//! Sparse factor P A P^T = L B L^T of a symmetric matrix that need not be definite,
//! supernodal, through faer: B has blocks of one and two rows, chosen inside each
//! supernode (J. Bunch and L. Kaufman, Math. Comp. 31, 1977).
//!
//! Sequential on purpose, as the Cholesky factor is: its bits do not depend on the
//! number of threads. The caller gives the ordering, which has to bring every row with
//! a zero on its diagonal after rows that it is coupled to. What the factor takes is
//! known from the pattern, before any number is touched.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, IntranodeLbltRef, SymbolicCholesky, SymbolicCholeskyRaw,
    SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

use super::cholesky::LowerColumns;
use super::{FactoriseError, Workspace};

/// The pattern of a factor and what it takes.
#[derive(Debug)]
pub struct IndefinitePattern {
    symbolic: Arc<SymbolicCholesky<u32>>,
    /// Floating-point operations of the factor's numbers.
    pub flops: f64,
}

/// A factor that solves.
#[derive(Debug)]
pub struct SparseIndefinite {
    symbolic: Arc<SymbolicCholesky<u32>>,
    values: Vec<f64>,
    below: Vec<f64>,
    forward: Vec<u32>,
    inverse: Vec<u32>,
}

impl IndefinitePattern {
    /// The pattern of the factor of `matrix` in the order `new_to_old` `[size]`.
    ///
    /// # Errors
    /// [`FactoriseError::OutOfMemory`] when its indices overflow.
    pub fn new(matrix: &LowerColumns, new_to_old: &[u32]) -> Result<Self, FactoriseError> {
        let size = matrix.size();
        let mut old_to_new = vec![0_u32; size];
        for (new, &old) in new_to_old.iter().enumerate() {
            old_to_new[old as usize] = new as u32;
        }
        let pattern =
            SymbolicSparseColMatRef::new_checked(size, size, &matrix.offsets, None, &matrix.rows);
        let symbolic = factorize_symbolic_cholesky(
            pattern,
            Side::Lower,
            SymmetricOrdering::Custom(PermRef::new_checked(new_to_old, &old_to_new, size)),
            CholeskySymbolicParams {
                supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
                ..Default::default()
            },
        )
        .map_err(|_| FactoriseError::OutOfMemory)?;
        Ok(Self {
            flops: flops(&symbolic),
            symbolic: Arc::new(symbolic),
        })
    }

    /// Bytes of a factor with this pattern.
    pub fn bytes(&self) -> u64 {
        8 * self.symbolic.len_val() as u64
    }

    /// Factorises `matrix`, which has the entries that the pattern was made from.
    ///
    /// # Errors
    /// [`FactoriseError`] when memory is short or a number is not finite, as after a
    /// pivot of zero.
    pub fn factorise(&self, matrix: &LowerColumns) -> Result<SparseIndefinite, FactoriseError> {
        let (symbolic, size) = (&self.symbolic, matrix.size());
        let mut values = Vec::new();
        values
            .try_reserve_exact(symbolic.len_val())
            .map_err(|_| FactoriseError::OutOfMemory)?;
        values.resize(symbolic.len_val(), 0.0);
        let scratch =
            symbolic.factorize_numeric_intranode_lblt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| FactoriseError::OutOfMemory)?;
        let mut factor = SparseIndefinite {
            symbolic: symbolic.clone(),
            values,
            below: vec![0.0; size],
            forward: vec![0; size],
            inverse: vec![0; size],
        };
        let pattern =
            SymbolicSparseColMatRef::new_checked(size, size, &matrix.offsets, None, &matrix.rows);
        symbolic.factorize_numeric_intranode_lblt(
            &mut factor.values,
            &mut factor.below,
            &mut factor.forward,
            &mut factor.inverse,
            SparseColMatRef::new(pattern, &matrix.values),
            Side::Lower,
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        if factor.values.iter().all(|value| value.is_finite()) {
            Ok(factor)
        } else {
            Err(FactoriseError::NotPositiveDefinite)
        }
    }
}

/// Multiplications and additions of the numbers of a factor: the square of each
/// column's length.
fn flops(symbolic: &SymbolicCholesky<u32>) -> f64 {
    let SymbolicCholeskyRaw::Supernodal(symbolic) = symbolic.raw() else {
        return f64::INFINITY;
    };
    let (starts, ends) = (symbolic.supernode_begin(), symbolic.supernode_end());
    let rows = symbolic.col_ptr_for_row_idx();
    let mut sum = 0.0;
    for (node, (start, end)) in starts.iter().zip(ends).enumerate() {
        let below = f64::from(rows[node + 1] - rows[node]);
        for width in 1..=end - start {
            sum += (below + f64::from(width)).powi(2);
        }
    }
    sum
}

impl SparseIndefinite {
    /// Number of negative eigenvalues of the matrix, which are those of B (Sylvester's law
    /// of inertia). Cost: a pass over the pivots.
    pub fn negative_eigenvalues(&self) -> usize {
        let SymbolicCholeskyRaw::Supernodal(symbolic) = self.symbolic.raw() else {
            return 0;
        };
        let (starts, ends) = (symbolic.supernode_begin(), symbolic.supernode_end());
        let (values, rows) = (symbolic.col_ptr_for_val(), symbolic.col_ptr_for_row_idx());
        let mut negative = 0;
        for (node, (&start, &end)) in starts.iter().zip(ends).enumerate() {
            let width = (end - start) as usize;
            let height = width + (rows[node + 1] - rows[node]) as usize;
            let own = &self.values[values[node] as usize..values[node + 1] as usize];
            let diagonal = |place: usize| own[place * height + place];
            let below = &self.below[start as usize..end as usize];
            let mut place = 0;
            while place < width {
                let coupled = below[place] != 0.0 && place + 1 < width;
                negative += if coupled {
                    negative_of_two(diagonal(place), below[place], diagonal(place + 1))
                } else {
                    usize::from(diagonal(place) < 0.0)
                };
                place += if coupled { 2 } else { 1 };
            }
        }
        negative
    }

    /// Bytes held by the values.
    pub fn bytes(&self) -> u64 {
        (8 * (self.values.len() + 2 * self.below.len())) as u64
    }

    /// Solves `A X = B` in place for right-hand sides one after the other `[count, size]`.
    pub fn solve(&self, x: &mut [f64], work: &mut Workspace) {
        let size = self.forward.len();
        let count = x.len() / size.max(1);
        let scratch = self.symbolic.solve_in_place_scratch::<f64>(count, Par::Seq);
        let mut memory = work.memory(scratch.unaligned_bytes_required());
        let pivots = PermRef::new_checked(&self.forward, &self.inverse, size);
        IntranodeLbltRef::<u32, f64>::new(&self.symbolic, &self.values, &self.below, pivots)
            .solve_in_place_with_conj(
                Conj::No,
                MatMut::from_column_major_slice_mut(x, size, count),
                Par::Seq,
                MemStack::new_any(&mut memory),
            );
        work.give_memory(memory);
    }
}

/// Negative eigenvalues of [a b; b c].
fn negative_of_two(a: f64, b: f64, c: f64) -> usize {
    if (a / b) * (c / b) < 1.0 {
        1
    } else {
        2 * usize::from(a < 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::vector::reproducible_noise;

    /// Springs in a row, their ends tied: [A B^T; B 0], the multipliers last.
    fn saddle(springs: usize) -> LowerColumns {
        let size = springs + 2;
        let mut matrix = LowerColumns {
            offsets: vec![0],
            ..LowerColumns::default()
        };
        for column in 0..size {
            let mut entries = vec![(column, if column < springs { 2.0 } else { 0.0 })];
            if column + 1 < springs {
                entries.push((column + 1, -1.0));
            }
            if column == 0 {
                entries.push((springs, 1.0));
            }
            if column + 1 == springs {
                entries.push((springs + 1, 3.0));
            }
            for (row, value) in entries {
                matrix.rows.push(row as u32);
                matrix.values.push(value);
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
    fn a_saddle_point_is_solved_to_rounding_in_any_order_of_its_rows() {
        let matrix = saddle(30);
        let forwards: Vec<u32> = (0..32).collect();
        let backwards: Vec<u32> = (0..30).rev().chain([31, 30]).collect();
        for order in [forwards, backwards] {
            let pattern = IndefinitePattern::new(&matrix, &order).expect("small");
            let factor = pattern.factorise(&matrix).expect("regular");
            let exact = reproducible_noise(32);
            let mut x = product(&matrix, &exact);
            factor.solve(&mut x, &mut Workspace::new());
            for (value, exact) in x.iter().zip(&exact) {
                assert!((value - exact).abs() < 1e-11, "{value} {exact}");
            }
        }
    }

    #[test]
    fn the_work_is_known_before_any_number_is() {
        let matrix = saddle(30);
        let order: Vec<u32> = (0..32).collect();
        let pattern = IndefinitePattern::new(&matrix, &order).expect("small");
        // Between that of a band of two and that of a full matrix.
        assert!((4.0 * 30.0..32.0_f64.powi(3)).contains(&pattern.flops));
        assert!((8 * 61..8 * 32 * 32).contains(&pattern.bytes()));
    }

    #[test]
    fn a_saddle_point_has_a_negative_eigenvalue_for_each_constraint_and_each_soft_motion() {
        let mut matrix = saddle(30);
        let order: Vec<u32> = (0..32).collect();
        let pattern = IndefinitePattern::new(&matrix, &order).expect("small");
        let negative = |matrix: &LowerColumns| {
            let factor = pattern.factorise(matrix).expect("regular");
            factor.negative_eigenvalues()
        };
        assert_eq!(negative(&matrix), 2);
        // Springs in a row, tied at both ends: 2 - 2 cos(k pi / 29), k = 1 .. 28.
        for soft in 1..28 {
            let between = std::f64::consts::PI * (soft as f64 + 0.5) / 29.0;
            let shift = 2.0 - 2.0 * between.cos();
            for column in 0..30 {
                matrix.values[matrix.offsets[column] as usize] = 2.0 - shift;
            }
            assert_eq!(negative(&matrix), 2 + soft);
        }
    }

    #[test]
    fn an_empty_column_is_refused() {
        let mut matrix = saddle(30);
        matrix.values.fill(0.0);
        let order: Vec<u32> = (0..32).collect();
        let pattern = IndefinitePattern::new(&matrix, &order).expect("small");
        assert!(pattern.factorise(&matrix).is_err());
    }
}
