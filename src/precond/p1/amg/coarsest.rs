//! The coarsest level: the dense inverse from a Cholesky factor.
//!
//! At some hundred unknowns it is a product of a few microseconds, and needs
//! no scratch.

use super::AmgError;
use super::block_rows::{BlockRows, wide};
use crate::linalg::Scalar;
use crate::linalg::SparseCholesky;
use crate::linalg::cholesky::{LowerColumns, Precision};

/// A dense symmetric inverse.
#[derive(Clone, Debug)]
pub(super) struct Coarsest<S> {
    /// Number of scalar unknowns of the coarsest level.
    size: usize,
    /// The dense inverse, column by column `[size, size]`; it is symmetric.
    inverse: Vec<S>,
}

impl<S: Scalar> Coarsest<S> {
    /// Inverts `matrix`.
    ///
    /// # Errors
    /// When it is not positive definite.
    pub(super) fn new<const K: usize>(matrix: &BlockRows<f64, K, K>) -> Result<Self, AmgError> {
        let size = K * matrix.rows();
        let order: Vec<u32> = (0..size as u32).collect();
        let factor = SparseCholesky::new(&lower_columns(matrix), &order, Precision::Double)?;
        let inverse = factor.trailing_block(size).inverse_of_product();
        let mean = |i: usize, j: usize| 0.5 * (inverse.at(i, j) + inverse.at(j, i));
        let entries = (0..size).flat_map(|j| (0..size).map(move |i| S::narrow(mean(i, j))));
        Ok(Self {
            size,
            inverse: entries.collect(),
        })
    }

    /// Number of scalar unknowns.
    pub(super) fn size(&self) -> usize {
        self.size
    }

    /// `x = A^-1 r` for W vectors side by side.
    pub(super) fn solve<const W: usize>(&self, r: &[S], x: &mut [S]) {
        x.fill(S::default());
        let columns = self.inverse.chunks_exact(self.size.max(1));
        wide::<W>(
            #[inline(always)]
            || {
                for (column, r) in columns.zip(r.as_chunks::<W>().0) {
                    for (sum, &entry) in x.as_chunks_mut::<W>().0.iter_mut().zip(column) {
                        for lane in 0..W {
                            sum[lane] += entry * r[lane];
                        }
                    }
                }
            },
        );
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        size_of_val(self.inverse.as_slice()) as u64
    }
}

/// The lower triangle, from the rows of the upper one.
fn lower_columns<const K: usize>(matrix: &BlockRows<f64, K, K>) -> LowerColumns {
    let mut lower = LowerColumns {
        offsets: vec![0],
        ..LowerColumns::default()
    };
    for node in 0..matrix.rows() {
        let (columns, blocks) = matrix.row(node);
        for j in 0..K {
            for (&other, block) in columns.iter().zip(blocks) {
                let first = match (other as usize).cmp(&node) {
                    std::cmp::Ordering::Less => K,
                    std::cmp::Ordering::Equal => j,
                    std::cmp::Ordering::Greater => 0,
                };
                for i in first..K {
                    lower.rows.push(other * K as u32 + i as u32);
                    lower.values.push(block[j][i]);
                }
            }
            lower.offsets.push(lower.rows.len() as u32);
        }
    }
    lower
}
