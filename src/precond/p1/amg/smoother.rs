//! Chebyshev smoothing around block Jacobi, fused: residual, direction and
//! iterate in one pass over the matrix.
//!
//! Step: `r -= A d`, `d' = keep d + gain D^-1 r`, `x += d'`. The polynomial is
//! the same before and after the coarse correction, so the cycle is symmetric;
//! it damps `[largest / RATIO, largest]` of D^-1 A.
//! Adams, Brezina, Hu and Tuminaro, J. Comput. Phys. 188 (2003).

use super::AmgError;
use super::block_rows::{
    Block, BlockRows, Lanes, PIECE, add_block_product, in_pieces, nodes, nodes_mut,
};
use super::strength::position_of_diagonal;
use crate::linalg::Scalar;
use crate::linalg::{Preconditioner, Workspace};
use crate::parallel::{self, Pieces};
use crate::precond::chebyshev::Chebyshev;
use crate::precond::spectrum::Lanczos;

/// Steps before and after the coarse correction.
pub(super) const DEGREE: usize = 2;
/// Ratio of the ends of the damped interval.
const RATIO: f64 = 8.0;
/// Lanczos steps for the largest eigenvalue.
const LANCZOS_STEPS: usize = 8;
/// The Lanczos process approaches it from below.
const SAFETY: f64 = 1.1;

/// Residual, next move and iterate of one row.
pub(super) struct RowStep<'a, S, const N: usize, const W: usize> {
    pub(super) r: &'a mut [Lanes<S, W>; N],
    pub(super) next: &'a mut [Lanes<S, W>; N],
    pub(super) x: &'a mut [Lanes<S, W>; N],
}

/// The same of all rows.
pub(super) struct AllRows<'a, S> {
    pub(super) r: &'a mut [S],
    pub(super) next: &'a mut [S],
    pub(super) x: &'a mut [S],
}

/// Inverted diagonal blocks, and the coefficients of the steps.
#[derive(Clone, Debug)]
pub(super) struct Smoother<S, const N: usize> {
    /// Inverted diagonal blocks of the level `[nodes]`.
    inverse: Vec<Block<S, N, N>>,
    /// `keep` and `gain` of each Chebyshev step: what stays of the last direction, and
    /// what the scaled residual adds.
    steps: [(S, S); DEGREE],
}

/// Inverses of the diagonal blocks.
///
/// # Errors
/// When one is not positive definite.
pub(super) fn inverse_diagonal<const N: usize>(
    matrix: &BlockRows<f64, N, N>,
) -> Result<Vec<Block<f64, N, N>>, AmgError> {
    let of_row = |row: usize| {
        let diagonal = position_of_diagonal(matrix, row);
        diagonal.and_then(|k| inverse(&matrix.blocks[k]))
    };
    let found = parallel::map(matrix.rows(), PIECE, &of_row).into_iter();
    found.map(|one| one.ok_or(AmgError::Indefinite)).collect()
}

/// Inverse of a symmetric positive definite block by Gauss-Jordan elimination,
/// which needs no pivoting there.
fn inverse<const N: usize>(block: &Block<f64, N, N>) -> Option<Block<f64, N, N>> {
    let mut a = *block;
    for pivot in 0..N {
        let value = a[pivot][pivot];
        // Rounding leaves this much of a pivot that is zero.
        if !(value > 1e-14 * block[pivot][pivot] && value.is_finite()) {
            return None;
        }
        let row = a[pivot];
        for i in (0..N).filter(|&i| i != pivot) {
            let factor = a[i][pivot] / value;
            for j in (0..N).filter(|&j| j != pivot) {
                a[i][j] -= factor * row[j];
            }
            a[i][pivot] = -factor;
        }
        for j in (0..N).filter(|&j| j != pivot) {
            a[pivot][j] = row[j] / value;
        }
        a[pivot][pivot] = 1.0 / value;
    }
    Some(a)
}

/// The inverted diagonal blocks as a preconditioner, by which the largest eigenvalue is
/// measured.
struct BlockJacobi<'a, const N: usize>(&'a [Block<f64, N, N>]);

impl<const N: usize> Preconditioner for BlockJacobi<'_, N> {
    fn apply(&self, r: &[f64], z: &mut [f64], _work: &mut Workspace) {
        let r = r.as_chunks::<N>().0;
        in_pieces(z.as_chunks_mut::<N>().0, |first, rows| {
            for (row, z) in rows.iter_mut().enumerate() {
                let lanes = r[first + row].map(|value| [value]);
                *z = times(&self.0[first + row], &lanes).map(|[value]| value);
            }
        });
    }
}

/// The product of a block with the values of one node on several right-hand sides at
/// once.
#[inline(always)]
fn times<S: Scalar, const N: usize, const W: usize>(
    block: &Block<S, N, N>,
    x: &[Lanes<S, W>; N],
) -> [Lanes<S, W>; N] {
    let mut y = [[S::default(); W]; N];
    add_block_product(&mut y, block, x);
    y
}

/// A bound of the largest eigenvalue of D^-1 A.
pub(super) fn largest_eigenvalue<const N: usize>(
    matrix: &BlockRows<f64, N, N>,
    inverse: &[Block<f64, N, N>],
    work: &mut Workspace,
) -> f64 {
    let lanczos = Lanczos {
        operator: matrix,
        preconditioner: &BlockJacobi(inverse),
        held: None,
        steps: LANCZOS_STEPS,
    };
    SAFETY * lanczos.interval(work).largest
}

impl<S: Scalar, const N: usize> Smoother<S, N> {
    /// Smoother of a matrix with eigenvalues of D^-1 A up to `largest`.
    pub(super) fn new(inverse: &[Block<f64, N, N>], largest: f64) -> Self {
        let mut chebyshev = Chebyshev::new(largest / RATIO, largest);
        let steps = [(); DEGREE].map(|()| {
            let step = chebyshev.advance();
            (S::narrow(step.keep), S::narrow(step.gain))
        });
        let narrow = |block: &Block<f64, N, N>| block.map(|row| row.map(S::narrow));
        Self {
            inverse: inverse.iter().map(narrow).collect(),
            steps,
        }
    }

    /// First step of a row from zero, `gain D^-1 r`.
    #[inline(always)]
    pub(super) fn first<const W: usize>(
        &self,
        row: usize,
        r: &[Lanes<S, W>; N],
    ) -> [Lanes<S, W>; N] {
        let gain = self.steps[0].1;
        let mut d = times(&self.inverse[row], r);
        for value in d.as_flattened_mut() {
            *value = gain * *value;
        }
        d
    }

    /// First step from zero: `d = gain D^-1 r`, `x = d`.
    pub(super) fn start(&self, r: &[S], d: &mut [S], x: &mut [S]) {
        let r = nodes::<S, N, 1>(r);
        let pieces = [d, x].map(|all| Pieces::of(all, PIECE * N));
        let [d, x] = pieces;
        parallel::each_of_two(d, x, 1, &|piece, d, x| {
            let (d, x) = (nodes_mut::<S, N, 1>(d), nodes_mut::<S, N, 1>(x));
            for (k, (d, x)) in d.iter_mut().zip(x).enumerate() {
                let row = piece * PIECE + k;
                *d = self.first(row, &r[row]);
                *x = *d;
            }
        });
    }

    /// Step `index` after `x` has moved by `d`; `next` becomes the next move.
    pub(super) fn step(
        &self,
        index: usize,
        matrix: &BlockRows<S, N, N>,
        d: &[S],
        AllRows { r, next, x }: AllRows<'_, S>,
    ) {
        let d = nodes::<S, N, 1>(d);
        let [r, next, x] = [r, next, x].map(|all| Pieces::of(all, PIECE * N));
        parallel::each_of_three(r, [next, x], 1, &|piece, r, [next, x]| {
            let (r, next) = (nodes_mut::<S, N, 1>(r), nodes_mut::<S, N, 1>(next));
            let x = nodes_mut::<S, N, 1>(x);
            for (k, ((r, next), x)) in r.iter_mut().zip(next).zip(x).enumerate() {
                let row = piece * PIECE + k;
                let product = matrix.row_product(row, d);
                self.step_of_row((index, row), (&product, &d[row]), RowStep { r, next, x });
            }
        });
    }

    /// One Chebyshev step of a row: residual, scaled residual, direction and iterate,
    /// side by side so that the row is read once.
    #[inline(always)]
    pub(super) fn step_of_row<const W: usize>(
        &self,
        (index, row): (usize, usize),
        (product, d): (&[Lanes<S, W>; N], &[Lanes<S, W>; N]),
        RowStep { r, next, x }: RowStep<'_, S, N, W>,
    ) {
        let (keep, gain) = self.steps[index];
        for i in 0..N {
            for lane in 0..W {
                r[i][lane] -= product[i][lane];
            }
        }
        let z = times(&self.inverse[row], r);
        for i in 0..N {
            for lane in 0..W {
                next[i][lane] = keep * d[i][lane] + gain * z[i][lane];
                x[i][lane] += next[i][lane];
            }
        }
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        size_of_val(self.inverse.as_slice()) as u64
    }
}
