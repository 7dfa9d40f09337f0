//! Products of block matrices, row by row (Gustavson 1978), and the Galerkin
//! matrix P^T A P.
//!
//! Cost: one block product per pair of stored blocks that meet; for A P some
//! 70, for P^T (A P) some 50 per vertex of a tetrahedral mesh.

use crate::parallel;
use rayon::prelude::*;

use super::block_rows::{Block, BlockRows, PIECE, Pattern};
use super::strength::position_of_diagonal;

/// Mark of a column that the present row has not met.
const UNSEEN: u32 = u32::MAX;

/// `A B`.
pub(super) fn product<const R: usize, const M: usize, const C: usize>(
    a: &BlockRows<f64, R, M>,
    b: &BlockRows<f64, M, C>,
) -> BlockRows<f64, R, C> {
    let pattern = product_pattern(&a.pattern, &b.pattern, b.columns);
    let mut blocks = vec![[[0.0; C]; R]; pattern.indices.len()];
    pieces_of(&pattern, &mut blocks)
        .into_par_iter()
        .for_each(|(first, last, blocks)| {
            let mut slot = vec![UNSEEN; b.columns];
            let start = pattern.offsets[first];
            for row in first..last {
                let own = pattern.range(row);
                for (k, &column) in own.clone().zip(pattern.row(row)) {
                    slot[column as usize] = k as u32 - start;
                }
                let (middles, lefts) = a.row(row);
                for (&middle, left) in middles.iter().zip(lefts) {
                    let (columns, rights) = b.row(middle as usize);
                    for (&column, right) in columns.iter().zip(rights) {
                        let target = &mut blocks[slot[column as usize] as usize];
                        add_product(target, left, right);
                    }
                }
            }
        });
    BlockRows {
        columns: b.columns,
        pattern,
        blocks,
    }
}

/// Adds the product of two blocks to `target` `[R, C]`.
#[inline]
fn add_product<const R: usize, const M: usize, const C: usize>(
    target: &mut Block<f64, R, C>,
    left: &Block<f64, R, M>,
    right: &Block<f64, M, C>,
) {
    for i in 0..R {
        for k in 0..M {
            for j in 0..C {
                target[i][j] += left[i][k] * right[k][j];
            }
        }
    }
}

/// A piece of whole rows: first row, end row, and their entries.
type RowPiece<'a, T> = (usize, usize, &'a mut [T]);

/// Cuts the entries of a matrix into pieces of whole rows: first row, end row,
/// their entries.
pub(super) fn pieces_of<'a, T>(pattern: &Pattern, entries: &'a mut [T]) -> Vec<RowPiece<'a, T>> {
    let rows = pattern.rows();
    let mut rest = entries;
    let mut pieces = Vec::new();
    for first in (0..rows).step_by(PIECE) {
        let last = rows.min(first + PIECE);
        let length = (pattern.offsets[last] - pattern.offsets[first]) as usize;
        let (piece, other) = rest.split_at_mut(length);
        pieces.push((first, last, piece));
        rest = other;
    }
    pieces
}

/// The pattern of the product A B, found piece by piece in parallel and put together in
/// order, so that it does not depend on the threads.
fn product_pattern(a: &Pattern, b: &Pattern, columns: usize) -> Pattern {
    let parts = parallel::map(a.rows().div_ceil(PIECE), 1, &|piece| {
        let first = piece * PIECE;
        pattern_of_rows(a, b, columns, first..a.rows().min(first + PIECE))
    });
    let mut offsets = vec![0];
    let mut indices = Vec::with_capacity(parts.iter().map(|part| part.1.len()).sum());
    let mut end = 0;
    for (counts, part) in parts {
        for count in counts {
            end += count;
            offsets.push(end);
        }
        indices.extend(part);
    }
    Pattern { offsets, indices }
}

/// Entries per row, and all columns, ascending within a row.
fn pattern_of_rows(
    a: &Pattern,
    b: &Pattern,
    columns: usize,
    rows: std::ops::Range<usize>,
) -> (Vec<u32>, Vec<u32>) {
    let mut seen_in = vec![UNSEEN; columns];
    let (mut counts, mut indices) = (Vec::with_capacity(rows.len()), Vec::new());
    for row in rows {
        let start = indices.len();
        for &middle in a.row(row) {
            for &column in b.row(middle as usize) {
                // The mark is the row itself, so that nothing is cleared between rows.
                if seen_in[column as usize] != row as u32 {
                    seen_in[column as usize] = row as u32;
                    indices.push(column);
                }
            }
        }
        indices[start..].sort_unstable();
        counts.push((indices.len() - start) as u32);
    }
    (counts, indices)
}

/// P^T A P, with ones on the diagonal where P has no column.
pub(super) fn galerkin<const N: usize, const K: usize>(
    matrix: &BlockRows<f64, N, N>,
    prolongation: &BlockRows<f64, N, K>,
    restriction: &BlockRows<f64, K, N>,
) -> BlockRows<f64, K, K> {
    // Modes that a group lacks have an empty row; a one keeps the factor below regular.
    let image = product(matrix, prolongation);
    let mut coarse = product(restriction, &image);
    for row in 0..coarse.rows() {
        if let Some(k) = position_of_diagonal(&coarse, row) {
            for mode in 0..K {
                let diagonal = &mut coarse.blocks[k][mode][mode];
                if *diagonal == 0.0 {
                    *diagonal = 1.0;
                }
            }
        }
    }
    coarse
}
