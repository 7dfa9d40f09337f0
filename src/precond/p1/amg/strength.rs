//! Which neighbours belong together: i and j are strongly coupled when
//! |A_ij| > theta sqrt(|A_ii| |A_jj|) in the Frobenius norm of blocks.
//!
//! Vanek, Mandel and Brezina 1996, equation 2.3. On isotropic meshes
//! theta = 0.02 keeps nearly every coupling, which makes the aggregates large
//! and the hierarchy cheap; across flat cells and soft layers it cuts.

use super::block_rows::{Block, BlockRows, PIECE};
use crate::parallel;

/// Smallest relative coupling that counts.
pub(super) const THRESHOLD: f32 = 0.02;
/// The same below the finest level, whose matrices have many weak couplings: on
/// meshes graded towards a contact 0.02 makes groups of 5 nodes, this of 11.
pub(super) const COARSE_THRESHOLD: f32 = 0.005;

/// Relative coupling of each stored block; zero on the diagonal and up to
/// `threshold`.
pub(super) fn couplings<const N: usize>(matrix: &BlockRows<f64, N, N>, threshold: f32) -> Vec<f32> {
    let norm_of = |k: usize| norm(&matrix.blocks[k]);
    let norms = parallel::map(matrix.blocks.len(), PIECE, &norm_of);
    let diagonal: Vec<f64> = (0..matrix.rows())
        .map(|row| position_of_diagonal(matrix, row).map_or(0.0, |k| norms[k].sqrt()))
        .collect();
    let mut couplings = vec![0.0; norms.len()];
    for row in 0..matrix.rows() {
        for k in matrix.pattern.range(row) {
            let column = matrix.pattern.indices[k] as usize;
            let relative = (norms[k] / (diagonal[row] * diagonal[column])) as f32;
            if column != row && relative > threshold {
                couplings[k] = relative;
            }
        }
    }
    couplings
}

/// Where the diagonal block of `row` is stored.
pub(super) fn position_of_diagonal<const N: usize>(
    matrix: &BlockRows<f64, N, N>,
    row: usize,
) -> Option<usize> {
    let found = matrix.pattern.row(row).binary_search(&(row as u32)).ok()?;
    Some(matrix.pattern.range(row).start + found)
}

/// Frobenius norm of a block.
fn norm<const N: usize>(block: &Block<f64, N, N>) -> f64 {
    let squares = block.iter().flatten().map(|value| value * value);
    squares.sum::<f64>().sqrt()
}
