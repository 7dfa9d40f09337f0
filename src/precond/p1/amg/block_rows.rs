//! Sparse matrices of small dense blocks `[R, C]`, block row by block row.
//!
//! A product reads every block once: 4 R C + 4 bytes per block in `f32`. Rows
//! are summed one by one in ascending columns, so the bits of a product do not
//! depend on the number of threads. W vectors that share a product lie side by
//! side, `[nodes, components, W]`: each keeps the bits it has alone.

use crate::linalg::Scalar;
use crate::linalg::{LinearOperator, Workspace};
use crate::parallel::{self, Pieces};

/// A dense block, row-major.
pub(super) type Block<S, const R: usize, const C: usize> = [[S; C]; R];

/// Block rows per parallel piece.
pub(super) const PIECE: usize = 512;

/// Which blocks of a matrix are stored.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Pattern {
    /// Start of each row in `indices` `[rows + 1]`.
    pub(super) offsets: Vec<u32>,
    /// Column of each stored block, ascending within a row.
    pub(super) indices: Vec<u32>,
}

impl Pattern {
    /// Places of one row's blocks in `indices`.
    pub(super) fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.offsets[row] as usize..self.offsets[row + 1] as usize
    }

    /// Number of block rows.
    pub(super) fn rows(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Columns of one row.
    pub(super) fn row(&self, row: usize) -> &[u32] {
        &self.indices[self.range(row)]
    }

    /// Bytes that the pattern holds.
    fn bytes(&self) -> u64 {
        4 * (self.offsets.len() + self.indices.len()) as u64
    }
}

/// A sparse matrix of blocks.
#[derive(Clone, Debug)]
pub(super) struct BlockRows<S, const R: usize, const C: usize> {
    /// Number of block columns.
    pub(super) columns: usize,
    /// Which blocks are stored.
    pub(super) pattern: Pattern,
    /// The stored blocks, in the order of the pattern.
    pub(super) blocks: Vec<Block<S, R, C>>,
}

/// `kernel(first, piece)` for every piece of `rows`, in parallel when there is
/// more than one.
pub(super) fn in_pieces<T: Send>(rows: &mut [T], kernel: impl Fn(usize, &mut [T]) + Sync) {
    if rows.len() <= PIECE {
        return kernel(0, rows);
    }
    parallel::each(Pieces::of(rows, PIECE), 1, &|piece, rows| {
        kernel(piece * PIECE, rows);
    });
}

/// W values, one for each of W vectors.
pub(super) type Lanes<S, const W: usize> = [S; W];

/// The nodes of W vectors of N components.
pub(super) fn nodes<S, const N: usize, const W: usize>(x: &[S]) -> &[[Lanes<S, W>; N]] {
    x.as_chunks::<W>().0.as_chunks::<N>().0
}

/// [`nodes`] to write to.
pub(super) fn nodes_mut<S, const N: usize, const W: usize>(x: &mut [S]) -> &mut [[Lanes<S, W>; N]] {
    x.as_chunks_mut::<W>().0.as_chunks_mut::<N>().0
}

/// Runs the kernel of one piece, of several vectors with the widest registers
/// of the machine: they neither fuse nor reorder, so the bits stay.
#[inline(always)]
pub(super) fn wide<const W: usize>(kernel: impl FnOnce()) {
    match W {
        1 => kernel(),
        _ => pulp::Arch::new().dispatch(kernel),
    }
}

/// `y += block x` in every lane.
#[inline(always)]
pub(super) fn add_block_product<S: Scalar, const R: usize, const C: usize, const W: usize>(
    y: &mut [Lanes<S, W>; R],
    block: &Block<S, R, C>,
    x: &[Lanes<S, W>; C],
) {
    for i in 0..R {
        for j in 0..C {
            for lane in 0..W {
                y[i][lane] += block[i][j] * x[j][lane];
            }
        }
    }
}

impl<S: Scalar, const R: usize, const C: usize> BlockRows<S, R, C> {
    /// Number of block rows.
    pub(super) fn rows(&self) -> usize {
        self.pattern.rows()
    }

    /// Columns and blocks of one row.
    pub(super) fn row(&self, row: usize) -> (&[u32], &[Block<S, R, C>]) {
        let range = self.pattern.range(row);
        (&self.pattern.indices[range.clone()], &self.blocks[range])
    }

    /// One row times `x`.
    #[inline(always)]
    pub(super) fn row_product<const W: usize>(
        &self,
        row: usize,
        x: &[[Lanes<S, W>; C]],
    ) -> [Lanes<S, W>; R] {
        let mut sum = [[S::default(); W]; R];
        let (columns, blocks) = self.row(row);
        for (&column, block) in columns.iter().zip(blocks) {
            add_block_product(&mut sum, block, &x[column as usize]);
        }
        sum
    }

    /// The same matrix in another number type.
    pub(super) fn converted<T: Scalar>(&self) -> BlockRows<T, R, C> {
        let mut blocks = vec![[[T::default(); C]; R]; self.blocks.len()];
        let (from, size) = (self.blocks.as_flattened().as_flattened(), PIECE * R * C);
        let into = Pieces::of(blocks.as_flattened_mut().as_flattened_mut(), size);
        parallel::each(into, 1, &|piece, into| {
            for (to, from) in into.iter_mut().zip(&from[piece * size..]) {
                *to = T::narrow(from.widen());
            }
        });
        BlockRows {
            columns: self.columns,
            pattern: self.pattern.clone(),
            blocks,
        }
    }

    /// The transposed matrix.
    pub(super) fn transposed(&self) -> BlockRows<S, C, R> {
        let mut offsets = vec![0_u32; self.columns + 1];
        for &column in &self.pattern.indices {
            offsets[column as usize + 1] += 1;
        }
        for column in 0..self.columns {
            offsets[column + 1] += offsets[column];
        }
        let mut next = offsets.clone();
        let mut indices = vec![0; self.pattern.indices.len()];
        let mut blocks = vec![[[S::default(); R]; C]; self.blocks.len()];
        for row in 0..self.rows() {
            let (columns, values) = self.row(row);
            for (&column, block) in columns.iter().zip(values) {
                let slot = next[column as usize] as usize;
                next[column as usize] += 1;
                indices[slot] = row as u32;
                blocks[slot] = transpose(block);
            }
        }
        BlockRows {
            columns: self.rows(),
            pattern: Pattern { offsets, indices },
            blocks,
        }
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        self.pattern.bytes() + size_of_val(self.blocks.as_slice()) as u64
    }
}

/// The transposed block `[C, R]`.
fn transpose<S: Scalar, const R: usize, const C: usize>(block: &Block<S, R, C>) -> Block<S, C, R> {
    let mut result = [[S::default(); R]; C];
    for i in 0..R {
        for j in 0..C {
            result[j][i] = block[i][j];
        }
    }
    result
}

/// Symmetric matrices as operators on `f64` vectors; sums are taken in `f64`.
impl<S: Scalar, const N: usize> LinearOperator for BlockRows<S, N, N> {
    fn rows(&self) -> usize {
        N * self.pattern.rows()
    }

    fn columns(&self) -> usize {
        N * self.columns
    }

    fn apply(&self, x: &[f64], y: &mut [f64], _work: &mut Workspace) {
        let x = x.as_chunks::<N>().0;
        in_pieces(y.as_chunks_mut::<N>().0, |first, rows| {
            for (row, sum) in rows.iter_mut().enumerate() {
                *sum = [0.0; N];
                let (columns, blocks) = self.row(first + row);
                for (&column, block) in columns.iter().zip(blocks) {
                    let x = &x[column as usize];
                    for i in 0..N {
                        for j in 0..N {
                            sum[i] += block[i][j].widen() * x[j];
                        }
                    }
                }
            }
        });
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }
}
