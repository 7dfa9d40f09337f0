//! Sparse Cholesky factor P A P^T = L L^T of a symmetric positive definite
//! matrix, supernodal, through faer.
//!
//! The factor is made by one thread: its bits must not depend on their number. Solves with one
//! right-hand side run along its branches (`branches`). The caller gives the ordering. In single
//! precision factor and solve cost half the time and memory; the error of a solution is then about
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
use tree::{Supernode, Tree};
use triangle::Factor;

mod branches;
mod tree;
mod triangle;

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

/// A number that faer makes factors of.
trait Scalar: RealField + Factor {}

impl Scalar for f32 {}
impl Scalar for f64 {}

/// A factor that solves.
#[derive(Debug)]
pub struct SparseCholesky {
    symbolic: SymbolicCholesky<u32>,
    values: Values,
    /// None where faer holds no supernodes.
    tree: Option<Tree>,
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
            tree: tree_of(&symbolic, size),
            symbolic,
            values,
            size,
        })
    }

    /// Solves `A X = B` in place for `count` right-hand sides, column by column.
    pub fn solve(&self, right_hand_sides: &mut [f64], count: usize, work: &mut Workspace) {
        match (self.tree.as_ref().filter(|_| count == 1), &self.values) {
            (Some(tree), Values::Single(values)) => tree.solve(values, right_hand_sides, work),
            (Some(tree), Values::Double(values)) => tree.solve(values, right_hand_sides, work),
            (None, _) => self.solve_all(right_hand_sides, count, work),
        }
    }

    /// [`Self::solve`] of several at once, as matrices.
    fn solve_all(&self, right_hand_sides: &mut [f64], count: usize, work: &mut Workspace) {
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
                            values[position].widen();
                    }
                }
            }
        }
        block
    }

    /// Bytes held by the values and the tree.
    pub fn bytes(&self) -> u64 {
        let values = match &self.values {
            Values::Single(values) => size_of_val(values.as_slice()),
            Values::Double(values) => size_of_val(values.as_slice()),
        };
        values as u64 + self.tree.as_ref().map_or(0, Tree::bytes)
    }
}

/// The tree of a factor.
fn tree_of(symbolic: &SymbolicCholesky<u32>, size: usize) -> Option<Tree> {
    let SymbolicCholeskyRaw::Supernodal(raw) = symbolic.raw() else {
        return None;
    };
    let ends = raw.supernode_end();
    let supernodes = (0..raw.n_supernodes()).map(|index| {
        let supernode = raw.supernode(index);
        Supernode {
            first: supernode.start(),
            width: ends[index] as usize - supernode.start(),
            below: supernode.pattern(),
            values: raw.col_ptr_for_val()[index] as usize,
        }
    });
    let supernodes: Vec<Supernode<'_>> = supernodes.collect();
    let same: Vec<u32> = (0..size as u32).collect();
    let unknowns = symbolic.perm().map_or(&same[..], |perm| perm.arrays().0);
    Some(Tree::new(&supernodes, unknowns))
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
    values.resize(symbolic.len_val(), T::narrow(0.0));
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
mod tests;
