//! The smoothed prolongator P = (I - w / lambda_max(D^-1 A) D^-1 A) P0.
//!
//! P0 is orthonormal and spans the modes on each group: B = P0 B_c, where B_c
//! are the triangular factors of the groups' modes; so P B_c = B - smoothed
//! A B, which is B wherever A maps the modes to zero.
//! Vanek, Mandel and Brezina, Computing 56 (1996).

use crate::parallel;
use rayon::prelude::*;

use super::aggregate::{Aggregates, NONE};
use super::block_rows::{Block, BlockRows, Pattern};
use super::galerkin::{pieces_of, product};
use super::modes::Modes;

/// A mode that keeps less than this part of its length is a combination of
/// those before it on this group.
const DEPENDENT: f64 = 1e-8;

/// P0 and the modes of the groups.
pub(super) fn tentative<const N: usize, const K: usize>(
    groups: &Aggregates,
    modes: &Modes<N, K>,
) -> (BlockRows<f64, N, K>, Modes<K, K>) {
    let members = groups.members();
    let factored = parallel::map(groups.count, 64, &|group| {
        orthonormalise(members.row(group).iter().map(|&node| modes[node as usize]))
    });
    let mut next = vec![0_usize; groups.count];
    let mut pattern = Pattern {
        offsets: vec![0],
        indices: Vec::with_capacity(members.indices.len()),
    };
    let mut blocks = Vec::with_capacity(members.indices.len());
    for &group in &groups.of_node {
        if group != NONE {
            let group_index = group as usize;
            blocks.push(factored[group_index].0[next[group_index]]);
            next[group_index] += 1;
            pattern.indices.push(group);
        }
        pattern.offsets.push(pattern.indices.len() as u32);
    }
    let prolongation = BlockRows {
        columns: groups.count,
        pattern,
        blocks,
    };
    let coarse = factored.into_iter().map(|(_, factor)| factor).collect();
    (prolongation, coarse)
}

/// `Q R` of stacked blocks by Gram-Schmidt, carried out twice; dependent
/// columns of Q and rows of R are zero.
fn orthonormalise<const N: usize, const K: usize>(
    blocks: impl Iterator<Item = Block<f64, N, K>>,
) -> (Vec<Block<f64, N, K>>, Block<f64, K, K>) {
    let mut q: Vec<Block<f64, N, K>> = blocks.collect();
    let mut factor = [[0.0; K]; K];
    for column in 0..K {
        let before = product_of_columns(&q, column, column).sqrt();
        // Once is not enough where modes are nearly dependent on a small group.
        for _ in 0..2 {
            for other in 0..column {
                let part = product_of_columns(&q, other, column);
                factor[other][column] += part;
                for row in q.iter_mut().flatten() {
                    row[column] -= part * row[other];
                }
            }
        }
        let length = product_of_columns(&q, column, column).sqrt();
        // A group of few nodes cannot carry all modes; those it lacks become zero.
        let is_dependent = length <= DEPENDENT * before;
        factor[column][column] = if is_dependent { 0.0 } else { length };
        for row in q.iter_mut().flatten() {
            row[column] = if is_dependent {
                0.0
            } else {
                row[column] / length
            };
        }
    }
    (q, factor)
}

/// Scalar product of columns a and b of a group's blocks, over all its nodes.
fn product_of_columns<const N: usize, const K: usize>(
    q: &[Block<f64, N, K>],
    a: usize,
    b: usize,
) -> f64 {
    q.iter().flatten().map(|row| row[a] * row[b]).sum()
}

/// P from P0: one damped Jacobi step on `matrix` with damping `weight`.
pub(super) fn smoothed<const N: usize, const K: usize>(
    matrix: &BlockRows<f64, N, N>,
    inverse_diagonal: &[Block<f64, N, N>],
    tentative: &BlockRows<f64, N, K>,
    weight: f64,
) -> BlockRows<f64, N, K> {
    let mut smoothed = product(matrix, tentative);
    let pattern = smoothed.pattern.clone();
    pieces_of(&pattern, &mut smoothed.blocks)
        .into_par_iter()
        .for_each(|(first, last, blocks)| {
            let start = pattern.offsets[first] as usize;
            for row in first..last {
                // P = P0 - weight D^-1 A P0; a node has one block of P0, that of its group.
                let own = tentative.row(row);
                for (k, column) in pattern.range(row).zip(pattern.row(row)) {
                    let block = &mut blocks[k - start];
                    *block = damped(&inverse_diagonal[row], block, weight);
                    if own.0.first() == Some(column) {
                        add(block, &own.1[0]);
                    }
                }
            }
        });
    smoothed
}

/// `-weight D^-1 block`.
fn damped<const N: usize, const K: usize>(
    inverse: &Block<f64, N, N>,
    block: &Block<f64, N, K>,
    weight: f64,
) -> Block<f64, N, K> {
    let mut result = [[0.0; K]; N];
    for i in 0..N {
        for k in 0..N {
            let factor = -weight * inverse[i][k];
            for j in 0..K {
                result[i][j] += factor * block[k][j];
            }
        }
    }
    result
}

/// Adds a block to another, entry by entry.
fn add<const N: usize, const K: usize>(target: &mut Block<f64, N, K>, other: &Block<f64, N, K>) {
    for (target, other) in target.iter_mut().flatten().zip(other.iter().flatten()) {
        *target += other;
    }
}
