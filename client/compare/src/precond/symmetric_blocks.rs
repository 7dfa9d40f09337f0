//! Symmetric sparse matrices of node blocks, strict lower triangle and diagonal
//! only: 8 C^2 + 4 bytes per block.
//!
//! A product reads each block once and is sequential, so its bits do not depend
//! on the number of threads.

use signorini::linalg::{LinearOperator, Workspace};
use signorini::precond::node_pairs::{Block, NodePairs};

/// A symmetric matrix `[nodes * C]`.
#[derive(Clone, Debug)]
pub(crate) struct SymmetricBlocks<const C: usize> {
    /// Start of each row of the strict lower triangle `[nodes + 1]`.
    pub(super) offsets: Vec<usize>,
    /// Column of each stored block, ascending within a row and below the diagonal.
    pub(super) columns: Vec<u32>,
    /// Blocks below the diagonal, row by row as `columns` name them.
    pub(super) lower: Vec<Block<C>>,
    /// Diagonal block of each node `[nodes]`.
    pub(super) diagonal: Vec<Block<C>>,
}

impl<const C: usize> SymmetricBlocks<C> {
    /// Rows and columns of `held` unknowns become the identity.
    pub(crate) fn new(blocks: &NodePairs<'_>, held: impl Iterator<Item = u32>) -> Self {
        let nodes = blocks.diagonal.len();
        let mut is_held = vec![[false; C]; nodes];
        for unknown in held {
            if let Some(flags) = is_held.get_mut(unknown as usize / C) {
                flags[unknown as usize % C] = true;
            }
        }
        let mut offsets = vec![0_usize; nodes + 1];
        for &[_, high] in blocks.pairs {
            offsets[high as usize + 1] += 1;
        }
        for node in 0..nodes {
            offsets[node + 1] += offsets[node];
        }
        let mut next = offsets.clone();
        let mut columns = vec![0; blocks.pairs.len()];
        let mut lower = vec![[[0.0; C]; C]; blocks.pairs.len()];
        for (&[low, high], block) in blocks.pairs.iter().zip(blocks.off) {
            let slot = next[high as usize];
            next[high as usize] += 1;
            columns[slot] = low;
            let (rows, others) = (is_held[high as usize], is_held[low as usize]);
            lower[slot] = free_part(|i, j| block[j][i], rows, others);
        }
        let diagonal = blocks.diagonal.iter().zip(&is_held).map(|(block, &held)| {
            let mut free = free_part(|i, j| block[i][j], held, held);
            (0..C).filter(|&i| held[i]).for_each(|i| free[i][i] = 1.0);
            free
        });
        Self {
            diagonal: diagonal.collect(),
            offsets,
            columns,
            lower,
        }
    }

    /// Columns and blocks of one row of the strict lower triangle.
    pub(super) fn row(&self, node: usize) -> (&[u32], &[Block<C>]) {
        let range = self.offsets[node]..self.offsets[node + 1];
        (&self.columns[range.clone()], &self.lower[range])
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        let blocks = (self.lower.len() + self.diagonal.len()) as u64;
        8 * (C * C) as u64 * blocks + 4 * self.columns.len() as u64 + 8 * self.offsets.len() as u64
    }
}

impl<const C: usize> LinearOperator for SymmetricBlocks<C> {
    fn rows(&self) -> usize {
        C * self.diagonal.len()
    }

    fn columns(&self) -> usize {
        self.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], _work: &mut Workspace) {
        let (x, y) = (x.as_chunks::<C>().0, y.as_chunks_mut::<C>().0);
        for node in 0..self.diagonal.len() {
            let mut sum = product(&self.diagonal[node], &x[node]);
            let (columns, blocks) = self.row(node);
            for (&column, block) in columns.iter().zip(blocks) {
                add_product(&mut sum, 1.0, block, &x[column as usize]);
                add_transposed_product(&mut y[column as usize], block, &x[node]);
            }
            y[node] = sum;
        }
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }
}

/// The block with held rows and columns zero, so that no unknown is coupled to a held
/// one.
fn free_part<const C: usize>(
    entry: impl Fn(usize, usize) -> f64,
    held_rows: [bool; C],
    held_columns: [bool; C],
) -> Block<C> {
    let free = |i: usize, j: usize| !(held_rows[i] || held_columns[j]);
    std::array::from_fn(|i| std::array::from_fn(|j| if free(i, j) { entry(i, j) } else { 0.0 }))
}

/// The product of one block with the values of one node `[C]`.
#[inline]
pub(super) fn product<const C: usize>(a: &Block<C>, x: &[f64; C]) -> [f64; C] {
    let mut sum = [0.0; C];
    add_product(&mut sum, 1.0, a, x);
    sum
}

/// Adds `factor` times the product of a block with the values of a node to `y` `[C]`.
#[inline]
pub(super) fn add_product<const C: usize>(
    y: &mut [f64; C],
    factor: f64,
    a: &Block<C>,
    x: &[f64; C],
) {
    for i in 0..C {
        for j in 0..C {
            y[i] += factor * a[i][j] * x[j];
        }
    }
}

/// Adds the product of a transposed block with the values of a node to `y` `[C]`.
#[inline]
pub(super) fn add_transposed_product<const C: usize>(y: &mut [f64; C], a: &Block<C>, x: &[f64; C]) {
    for i in 0..C {
        for j in 0..C {
            y[j] += a[i][j] * x[i];
        }
    }
}
