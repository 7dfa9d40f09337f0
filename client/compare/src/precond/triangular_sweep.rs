//! Triangular sweeps `M = (D + L) D^-1 (D + L^T)` over symmetric block matrices.
//!
//! With the matrix's own L and D a sweep is symmetric block Gauss-Seidel; with
//! those of an incomplete factorisation of level 0 (the pattern of the matrix)
//! it is block incomplete Cholesky. Y. Saad, Iterative Methods for Sparse
//! Linear Systems, chapters 4 and 10. A sweep reads the lower triangle twice and
//! is sequential, so its bits do not depend on the number of threads.

use crate::precond::symmetric_blocks::{
    SymmetricBlocks, add_product, add_transposed_product, product,
};
use signorini::linalg::{Preconditioner, Workspace};
use signorini::precond::node_pairs::Block;

/// Relative shifts of the diagonal that are tried one after the other, where
/// the incomplete factorisation breaks down.
const SHIFTS: [f64; 8] = [0.0, 1e-3, 4e-3, 1.6e-2, 6.4e-2, 0.25, 1.0, 4.0];
/// A pivot below this part of the matrix's own diagonal counts as break-down.
const LEAST_PIVOT: f64 = 1e-3;

/// Inverse of `(D + L) D^-1 (D + L^T)`.
#[derive(Clone, Debug)]
pub(crate) struct TriangularSweep<const C: usize> {
    /// D and L by nodes; rows of held components couple to nothing.
    matrix: SymmetricBlocks<C>,
    /// Inverted blocks of D `[nodes]`, which may be those of the matrix or corrected
    /// ones of an incomplete factor.
    inverse: Vec<Block<C>>,
}

impl<const C: usize> TriangularSweep<C> {
    /// Symmetric block Gauss-Seidel of `matrix`.
    pub(crate) fn gauss_seidel(matrix: SymmetricBlocks<C>) -> Self {
        let inverse = matrix.diagonal.iter();
        Self {
            inverse: inverse
                .map(|block| inverted(block, &[0.0; C]).unwrap_or_else(|| diagonal_inverse(block)))
                .collect(),
            matrix,
        }
    }

    /// Incomplete Cholesky factor of `matrix` on its own pattern, its diagonal
    /// enlarged by the least of a few shifts that keeps every pivot positive;
    /// block Gauss-Seidel where none does.
    pub(crate) fn incomplete(matrix: &SymmetricBlocks<C>) -> Self {
        let mut tries = SHIFTS.iter().map(|&shift| factorise(matrix, shift));
        tries
            .find_map(|found| found)
            .unwrap_or_else(|| Self::gauss_seidel(matrix.clone()))
    }

    /// Whether `matrix` has no incomplete factor without a shift.
    #[cfg(test)]
    pub(crate) fn needs_shift(matrix: &SymmetricBlocks<C>) -> bool {
        factorise(matrix, 0.0).is_none()
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        self.matrix.bytes() + 8 * (C * C * self.inverse.len()) as u64
    }
}

impl<const C: usize> Preconditioner for TriangularSweep<C> {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let (r, z) = (r.as_chunks::<C>().0, z.as_chunks_mut::<C>().0);
        for node in 0..self.inverse.len() {
            // Forwards: (D + L) y = r.
            let mut sum = r[node];
            let (columns, blocks) = self.matrix.row(node);
            for (&column, block) in columns.iter().zip(blocks) {
                add_product(&mut sum, -1.0, block, &z[column as usize]);
            }
            z[node] = product(&self.inverse[node], &sum);
        }
        // Backwards by columns, since L is stored by rows: each node hands its value on to
        // the sums of the nodes before it.
        let mut above = work.zeros(C * z.len());
        let sums = above.as_chunks_mut::<C>().0;
        for node in (0..self.inverse.len()).rev() {
            let correction = product(&self.inverse[node], &sums[node]);
            (0..C).for_each(|i| z[node][i] -= correction[i]);
            let (columns, blocks) = self.matrix.row(node);
            for (&column, block) in columns.iter().zip(blocks) {
                add_transposed_product(&mut sums[column as usize], block, &z[node]);
            }
        }
        work.give(above);
    }
}

/// W and D with `(W + D) D^-1 (W + D)^T` equal to the shifted matrix on its own
/// pattern; none where a pivot is not positive.
fn factorise<const C: usize>(
    matrix: &SymmetricBlocks<C>,
    shift: f64,
) -> Option<TriangularSweep<C>> {
    let mut factor = matrix.clone();
    let mut inverse: Vec<Block<C>> = Vec::with_capacity(matrix.diagonal.len());
    for row in 0..matrix.diagonal.len() {
        let least = std::array::from_fn(|i| LEAST_PIVOT * matrix.diagonal[row][i][i]);
        (0..C).for_each(|i| factor.diagonal[row][i][i] *= 1.0 + shift);
        for entry in matrix.offsets[row]..matrix.offsets[row + 1] {
            let column = matrix.columns[entry] as usize;
            let earlier = matrix.offsets[row]..entry;
            // Fill is dropped: only entries of the pattern are reached.
            let block = eliminated(&factor, &inverse, earlier, entry, column);
            factor.lower[entry] = block;
            let scaled = times(&block, &inverse[column]);
            subtract_times_transposed(&mut factor.diagonal[row], &scaled, &block);
        }
        inverse.push(inverted(&factor.diagonal[row], &least)?);
    }
    Some(TriangularSweep {
        matrix: factor,
        inverse,
    })
}

/// The block `entry` of a row minus what the row's `earlier` blocks share with
/// the row of its column.
fn eliminated<const C: usize>(
    factor: &SymmetricBlocks<C>,
    inverse: &[Block<C>],
    earlier: std::ops::Range<usize>,
    entry: usize,
    column: usize,
) -> Block<C> {
    let mut block = factor.lower[entry];
    let (others, other_blocks) = factor.row(column);
    let mut position = 0;
    for own in earlier {
        let shared = factor.columns[own];
        // Both rows ascend: one walk finds all columns that they share.
        while position < others.len() && others[position] < shared {
            position += 1;
        }
        if others.get(position) == Some(&shared) {
            let scaled = times(&factor.lower[own], &inverse[shared as usize]);
            subtract_times_transposed(&mut block, &scaled, &other_blocks[position]);
        }
    }
    block
}

/// The product of two blocks `[C, C]`.
fn times<const C: usize>(a: &Block<C>, b: &Block<C>) -> Block<C> {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..C).map(|k| a[i][k] * b[k][j]).sum()))
}

/// `a -= b c^T`.
fn subtract_times_transposed<const C: usize>(a: &mut Block<C>, b: &Block<C>, c: &Block<C>) {
    for i in 0..C {
        for j in 0..C {
            a[i][j] -= (0..C).map(|k| b[i][k] * c[j][k]).sum::<f64>();
        }
    }
}

/// Gauss-Jordan inverse of a symmetric block; none unless each pivot is
/// positive and above its bound.
fn inverted<const C: usize>(block: &Block<C>, least: &[f64; C]) -> Option<Block<C>> {
    let mut rest = *block;
    let mut inverse: Block<C> =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for k in 0..C {
        let pivot = rest[k][k];
        if !(pivot > least[k] && pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        for j in 0..C {
            rest[k][j] /= pivot;
            inverse[k][j] /= pivot;
        }
        for i in (0..C).filter(|&i| i != k) {
            let factor = rest[i][k];
            for j in 0..C {
                rest[i][j] -= factor * rest[k][j];
                inverse[i][j] -= factor * inverse[k][j];
            }
        }
    }
    Some(inverse)
}

/// The reciprocal diagonal of a block without inverse; one where the diagonal is not
/// positive.
fn diagonal_inverse<const C: usize>(block: &Block<C>) -> Block<C> {
    let entry = |i: usize| {
        if block[i][i] > 0.0 {
            1.0 / block[i][i]
        } else {
            1.0
        }
    };
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { entry(i) } else { 0.0 }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use signorini::linalg::LinearOperator;
    use signorini::linalg::vector::reproducible_noise;
    use signorini::precond::node_pairs::NodePairs;

    /// A chain of three nodes: its factor needs no fill, so level 0 is exact.
    fn chain(coupling: f64) -> SymmetricBlocks<2> {
        let node = [[4.0, 1.0, 0.0], [1.0, 3.0, 0.0], [0.0; 3]];
        let link = [[coupling, 0.5, 0.0], [-0.3, coupling, 0.0], [0.0; 3]];
        let blocks = NodePairs {
            diagonal: &[node; 3],
            pairs: &[[0, 1], [1, 2]],
            off: &[link; 2],
        };
        SymmetricBlocks::new(&blocks, std::iter::empty())
    }

    fn applied(operator: &SymmetricBlocks<2>, x: &[f64]) -> Vec<f64> {
        let mut y = vec![f64::NAN; x.len()];
        operator.apply(x, &mut y, &mut Workspace::new());
        y
    }

    fn swept(sweep: &TriangularSweep<2>, r: &[f64]) -> Vec<f64> {
        let mut z = vec![f64::NAN; r.len()];
        sweep.apply(r, &mut z, &mut Workspace::new());
        z
    }

    #[test]
    fn a_factor_without_fill_solves_its_matrix() {
        let matrix = chain(-1.0);
        let exact = reproducible_noise(6);
        let found = swept(
            &TriangularSweep::incomplete(&matrix),
            &applied(&matrix, &exact),
        );
        for (a, b) in found.iter().zip(&exact) {
            assert!((a - b).abs() < 1e-14, "{a} {b}");
        }
    }

    #[test]
    fn an_indefinite_matrix_gets_a_shift_and_stays_positive() {
        let matrix = chain(-3.5);
        assert!(TriangularSweep::needs_shift(&matrix));
        let sweep = TriangularSweep::incomplete(&matrix);
        let r = reproducible_noise(6);
        let z = swept(&sweep, &r);
        assert!(z.iter().zip(&r).map(|(a, b)| a * b).sum::<f64>() > 0.0);
    }

    #[test]
    fn a_gauss_seidel_sweep_is_symmetric_and_takes_the_matrix_by_its_triangles() {
        let matrix = chain(-1.0);
        let sweep = TriangularSweep::gauss_seidel(matrix.clone());
        // (D + L) D^-1 (D + L^T) = A + L D^-1 L^T, and L^T takes nothing from
        // the first node.
        let x = [1.0, -2.0, 0.0, 0.0, 0.0, 0.0];
        for (a, b) in swept(&sweep, &applied(&matrix, &x)).iter().zip(x) {
            assert!((a - b).abs() < 1e-14);
        }
        let (a, b) = (reproducible_noise(6), vec![1.0, 2.0, 3.0, -1.0, 0.5, 4.0]);
        let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
        let (left, right) = (dot(&swept(&sweep, &a), &b), dot(&swept(&sweep, &b), &a));
        assert!((left - right).abs() < 1e-13, "{left} {right}");
    }

    #[test]
    #[allow(clippy::float_cmp)] // These values are exact.
    fn held_unknowns_pass_through_and_couple_to_nothing() {
        let node = [[4.0, 1.0, 0.0], [1.0, 3.0, 0.0], [0.0; 3]];
        let blocks = NodePairs {
            diagonal: &[node; 2],
            pairs: &[[0, 1]],
            off: &[[[-1.0; 3]; 3]],
        };
        let matrix = SymmetricBlocks::<2>::new(&blocks, [1].into_iter());
        assert_eq!(
            applied(&matrix, &[0.0, 7.0, 0.0, 0.0]),
            [0.0, 7.0, 0.0, 0.0]
        );
        let z = swept(
            &TriangularSweep::gauss_seidel(matrix),
            &[0.0, 5.0, 0.0, 0.0],
        );
        assert_eq!(z, [0.0, 5.0, 0.0, 0.0]);
    }
}
