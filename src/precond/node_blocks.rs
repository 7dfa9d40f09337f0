//! Block Jacobi with one block per node (2 by 2 or 3 by 3), and the Chebyshev
//! update built on it.
//!
//! Blocks of held components must carry the identity there, as the operator
//! does; otherwise the largest eigenvalue grows several times.

use crate::parallel::{self, Pieces};
use std::collections::BTreeMap;

use crate::linalg::{Preconditioner, Scalar, Workspace};

/// Nodes per parallel piece.
const PIECE: usize = 2048;
/// Pieces that a thread takes at least: waking another costs as much as they do.
const FEWEST: usize = 3;

/// Inverted symmetric node blocks, in single precision: they only say which way to step, and
/// reading them is a large part of a step.
#[derive(Clone, Debug)]
pub struct NodeBlocks {
    /// Components of a node: 2 or 3, which is the size of a block.
    components: usize,
    /// Upper triangles of the blocks, row by row `[nodes, 3 or 6]`.
    inverse: Vec<f32>,
    /// Blocks between two nodes that move together, the first one under a load on the second, by
    /// nodes; empty where nodes move alone. Sweeps leave them out.
    pairs: Vec<([u32; 2], [f64; 9])>,
}

impl NodeBlocks {
    /// Inverts `blocks` `[nodes, components, components]`. A block that cannot
    /// be inverted becomes the inverse of its diagonal.
    pub fn invert(components: usize, mut blocks: Vec<f64>) -> Self {
        let size = components * components;
        parallel::each(
            Pieces::of(&mut blocks, size),
            1,
            &|_, block| match components {
                2 => invert_2(block),
                _ => invert_3(block),
            },
        );
        Self::of_inverse(components, &blocks)
    }

    /// Of inverse blocks `[nodes, components, components]`.
    pub fn of_inverse(components: usize, blocks: &[f64]) -> Self {
        let size = components * components;
        let nodes = blocks.chunks_exact(size);
        let upper = nodes.flat_map(|block| {
            let entry = move |(i, j): (usize, usize)| block[i * components + j] as f32;
            let rows = (0..components).flat_map(move |i| (i..components).map(move |j| (i, j)));
            rows.map(entry)
        });
        Self {
            components,
            inverse: upper.collect(),
            pairs: Vec::new(),
        }
    }

    /// With blocks between nodes, row-major `[components, components]`, zeros after it.
    #[must_use]
    pub fn with_pairs(self, pairs: BTreeMap<[u32; 2], [f64; 9]>) -> Self {
        Self {
            pairs: pairs.into_iter().collect(),
            ..self
        }
    }

    /// The blocks of one node with others that move it.
    pub fn pairs_of(&self, node: u32) -> &[([u32; 2], [f64; 9])] {
        let first = self.pairs.partition_point(|(pair, _)| pair[0] < node);
        let end = self.pairs.partition_point(|(pair, _)| pair[0] <= node);
        &self.pairs[first..end]
    }

    /// Components per node.
    pub fn components(&self) -> usize {
        self.components
    }

    /// The inverse block of one node, row-major `[components, components]`, zeros after it.
    pub fn block(&self, node: usize) -> [f64; 9] {
        let c = self.components;
        let size = c * (c + 1) / 2;
        let own = &self.inverse[node * size..(node + 1) * size];
        let mut block = [0.0; 9];
        let rows = (0..c).flat_map(|i| (i..c).map(move |j| (i, j)));
        for ((i, j), &value) in rows.zip(own) {
            block[i * c + j] = f64::from(value);
            block[j * c + i] = f64::from(value);
        }
        block
    }

    /// The first step of a Chebyshev recurrence from nothing: `d = gain D^-1 r`, `x = d`.
    pub fn chebyshev_start<R: Scalar>(&self, gain: f64, r: &[R], d: &mut [R], x: &mut [R]) {
        let gain = R::narrow(gain);
        self.sweep(r, d, x, |step, d, x| {
            *d = gain * step;
            *x = *d;
        });
    }

    /// The first step after a correction, which `d` holds: `x += d + gain D^-1 r`,
    /// `d = gain D^-1 r`.
    pub fn chebyshev_restart<R: Scalar>(&self, gain: f64, r: &[R], d: &mut [R], x: &mut [R]) {
        let gain = R::narrow(gain);
        self.sweep(r, d, x, |step, d, x| {
            *x += *d + gain * step;
            *d = gain * step;
        });
    }

    /// One step of the Chebyshev recurrence:
    /// `d = keep d + gain D^-1 r`, `x += d`.
    pub fn chebyshev_update<R: Scalar>(
        &self,
        (keep, gain): (f64, f64),
        r: &[R],
        d: &mut [R],
        x: &mut [R],
    ) {
        let (keep, gain) = (R::narrow(keep), R::narrow(gain));
        self.sweep(r, d, x, |step, d, x| {
            *d = keep * *d + gain * step;
            *x += *d;
        });
    }

    /// Shows `change` each entry of D^-1 r, d and x.
    fn sweep<R: Scalar>(
        &self,
        r: &[R],
        d: &mut [R],
        x: &mut [R],
        change: impl Fn(R, &mut R, &mut R) + Sync,
    ) {
        match self.components {
            2 => self.pieces::<2, 3, R>(r, d, x, |[a, b, c], &[x, y], d, z| {
                let [a, b, c] = [*a, *b, *c].map(R::of_single);
                change(a * x + b * y, &mut d[0], &mut z[0]);
                change(b * x + c * y, &mut d[1], &mut z[1]);
            }),
            _ => self.pieces::<3, 6, R>(r, d, x, |block, &[x, y, z], d, at| {
                let [a, b, c, e, f, g] = block.map(R::of_single);
                change(a * x + b * y + c * z, &mut d[0], &mut at[0]);
                change(b * x + e * y + f * z, &mut d[1], &mut at[1]);
                change(c * x + f * y + g * z, &mut d[2], &mut at[2]);
            }),
        }
    }

    /// Shows `visit` each node of C components with its block of N numbers, in parallel pieces
    /// of fixed size.
    fn pieces<const C: usize, const N: usize, R: Scalar>(
        &self,
        r: &[R],
        d: &mut [R],
        x: &mut [R],
        visit: impl Fn(&[f32; N], &[R; C], &mut [R; C], &mut [R; C]) + Sync,
    ) {
        let piece = PIECE * C;
        let (r, inverse) = (r.as_chunks::<C>().0, self.inverse.as_chunks::<N>().0);
        let (d, x) = (Pieces::of(d, piece), Pieces::of(x, piece));
        parallel::each_of_two(d, x, FEWEST, &|k, d, x| {
            let (d, x) = (d.as_chunks_mut::<C>().0, x.as_chunks_mut::<C>().0);
            let data = r[k * PIECE..].iter().zip(&inverse[k * PIECE..]);
            for ((d, x), (r, block)) in d.iter_mut().zip(x).zip(data) {
                visit(block, r, d, x);
            }
        });
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        4 * self.inverse.len() as u64 + size_of_val(&self.pairs[..]) as u64
    }
}

impl Preconditioner for NodeBlocks {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let mut d = work.scratch(r.len());
        self.chebyshev_start(1.0, r, &mut d, z);
        work.give(d);
    }
}

/// Whether all `blocks` `[nodes, components, components]` are positive definite.
pub fn are_positive(components: usize, blocks: &[f64]) -> bool {
    let is_positive = |b: &[f64]| match components {
        2 => b[0] > 0.0 && b[0] * b[3] > b[1] * b[2],
        _ => {
            let [minor, first, second] = [
                b[0] * b[4] - b[1] * b[3],
                b[1] * b[5] - b[2] * b[4],
                b[0] * b[5] - b[2] * b[3],
            ];
            b[0] > 0.0 && minor > 0.0 && b[8] * minor + b[6] * first > b[7] * second
        }
    };
    blocks
        .chunks_exact(components * components)
        .all(is_positive)
}

/// Inverts a symmetric block of two rows in place, or its diagonal where the
/// determinant is not positive.
fn invert_2(b: &mut [f64]) {
    let determinant = b[0] * b[3] - b[1] * b[2];
    if determinant > 0.0 && determinant.is_finite() {
        let inverse = [b[3], -b[1], -b[2], b[0]].map(|value| value / determinant);
        b.copy_from_slice(&inverse);
    } else {
        invert_diagonal(b, 2);
    }
}

/// Inverts a symmetric block of three rows in place by cofactors, or its diagonal where
/// the determinant is not positive.
fn invert_3(b: &mut [f64]) {
    let minor = |i: usize, j: usize, k: usize, l: usize| b[i] * b[l] - b[j] * b[k];
    let cofactors = [
        minor(4, 5, 7, 8),
        -minor(1, 2, 7, 8),
        minor(1, 2, 4, 5),
        -minor(3, 5, 6, 8),
        minor(0, 2, 6, 8),
        -minor(0, 2, 3, 5),
        minor(3, 4, 6, 7),
        -minor(0, 1, 6, 7),
        minor(0, 1, 3, 4),
    ];
    let determinant = b[0] * cofactors[0] + b[1] * cofactors[3] + b[2] * cofactors[6];
    if determinant > 0.0 && determinant.is_finite() {
        b.copy_from_slice(&cofactors.map(|value| value / determinant));
    } else {
        invert_diagonal(b, 3);
    }
}

/// Inverts the diagonal of a block in place; entries that are not positive become one,
/// all others zero.
fn invert_diagonal(b: &mut [f64], size: usize) {
    for i in 0..size {
        for j in 0..size {
            let entry = b[i * size + j];
            b[i * size + j] = if i != j {
                0.0
            } else if entry > 0.0 {
                1.0 / entry
            } else {
                1.0
            };
        }
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // These values are exact.
mod tests {
    use super::*;

    #[test]
    fn blocks_times_their_inverse_are_the_identity() {
        let three = vec![4.0, 1.0, 0.5, 1.0, 3.0, 0.2, 0.5, 0.2, 2.0];
        let inverse = NodeBlocks::invert(3, three.clone());
        for i in 0..3 {
            for j in 0..3 {
                let sum: f64 = (0..3)
                    .map(|k| three[3 * i + k] * inverse.block(0)[3 * k + j])
                    .sum();
                assert!((sum - f64::from(u8::from(i == j))).abs() < 1e-6);
            }
        }
        let two = NodeBlocks::invert(2, vec![2.0, 1.0, 1.0, 3.0]);
        for (value, exact) in two.block(0).iter().zip([0.6, -0.2, -0.2, 0.4]) {
            assert!((value - exact).abs() < 1e-7);
        }
    }

    #[test]
    fn a_singular_block_falls_back_to_its_diagonal() {
        let blocks = NodeBlocks::invert(2, vec![2.0, 2.0, 2.0, 2.0]);
        assert_eq!(blocks.block(0)[..4], [0.5, 0.0, 0.0, 0.5]);
    }
}
