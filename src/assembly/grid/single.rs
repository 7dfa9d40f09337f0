//! Products with A in single precision, for preconditioners: half the bytes, sixteen cells at a
//! time. Nodes, ends of edges and held entries are those of the grid in double precision; cells
//! and order of sums are the same. Memory: 72 bytes a tetrahedron.

use crate::parallel;
use std::sync::Arc;

use super::{Basis, CellGrid, Grid, Rows};
use crate::assembly::kernel::Batch;
use crate::assembly::lanes::{Lanes, SINGLE_WIDTH, WIDTH};
use crate::assembly::simd::{self, InstructionSet};
use crate::assembly::transpose::Row;
use crate::linalg::{Scalar, Workspace};

/// Batches in double precision that one in single precision holds.
const PAIR: usize = SINGLE_WIDTH / WIDTH;

/// One batch in single precision.
type SingleBatch<const V: usize, const D: usize, const E: usize> =
    Batch<V, D, E, f32, SINGLE_WIDTH>;

/// A grid whose cells are known in single precision too.
#[derive(Clone, Debug)]
pub enum SingleGrid {
    /// Plane.
    Triangles(SingleCells<3, 2, 3>),
    /// Solid.
    Tetrahedra(SingleCells<4, 3, 6>),
}

/// A grid and the batches of each of its blocks in single precision.
#[derive(Clone, Debug)]
pub struct SingleCells<const V: usize, const D: usize, const E: usize> {
    grid: Arc<CellGrid<V, D, E>>,
    blocks: Vec<Vec<SingleBatch<V, D, E>>>,
}

impl SingleGrid {
    /// The cells of `grid`, rounded.
    pub fn new(grid: &Grid) -> Self {
        match grid {
            Grid::Triangles(grid) => Self::Triangles(SingleCells::new(grid)),
            Grid::Tetrahedra(grid) => Self::Tetrahedra(SingleCells::new(grid)),
        }
    }

    /// `r -= A x` with the volume term of the approximate inverse, on all nodes, held entries of
    /// both left out.
    pub fn subtract_stiffness(&self, basis: Basis, x: &[f32], r: &mut [f32], work: &mut Workspace) {
        match self {
            Self::Triangles(cells) => cells.subtract_stiffness(basis, x, r, work),
            Self::Tetrahedra(cells) => cells.subtract_stiffness(basis, x, r, work),
        }
    }

    /// Bytes held beside those of the grid.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Triangles(cells) => cells.bytes(),
            Self::Tetrahedra(cells) => cells.bytes(),
        }
    }
}

impl<const V: usize, const D: usize, const E: usize> SingleCells<V, D, E> {
    pub(in crate::assembly) fn new(grid: &Arc<CellGrid<V, D, E>>) -> Self {
        let of_block = |batches: &[Batch<V, D, E>]| batches.chunks(PAIR).map(joined).collect();
        Self {
            grid: grid.clone(),
            blocks: parallel::map(grid.blocks.len(), 1, &|k| of_block(&grid.blocks[k].batches)),
        }
    }

    /// Batches of a block.
    pub(in crate::assembly) fn batches(&self, block: usize) -> &[SingleBatch<V, D, E>] {
        &self.blocks[block]
    }

    /// The kernels that run here.
    pub(in crate::assembly) fn instructions(&self) -> InstructionSet {
        self.grid.instructions
    }

    pub(in crate::assembly) fn bytes(&self) -> u64 {
        let batches: usize = self.blocks.iter().map(Vec::len).sum();
        (batches * size_of::<SingleBatch<V, D, E>>()) as u64
    }

    fn subtract_stiffness(&self, basis: Basis, x: &[f32], r: &mut [f32], work: &mut Workspace) {
        let instructions = self.grid.instructions;
        self.subtract(basis, (x, r), work, |block, x, y| {
            simd::augmented_stiffness(instructions, &self.blocks[block], x, y);
        });
    }

    /// Takes off `r` what `product` makes of `x` on the rows of each block, held entries of both
    /// left out.
    pub(in crate::assembly) fn subtract(
        &self,
        basis: Basis,
        (x, r): (&[f32], &mut [f32]),
        work: &mut Workspace,
        product: impl Fn(usize, &[Row<f32>], &mut [Row<f32>]) + Sync,
    ) {
        let grid = &*self.grid;
        grid.pass(
            work,
            |block, x_rows| {
                block.gather_displacement(x, x_rows);
                block.prepare_argument(basis, Rows::Free, x_rows);
            },
            |index, block, x, y| {
                product(index, x, y);
                block.finish_result(basis, Rows::Free, y);
            },
            |local| {
                grid.copies.sum::<D, f32>(local, r, |target, sum| {
                    for i in 0..D {
                        target[i] -= sum[i];
                    }
                });
            },
        );
    }
}

/// Up to two batches as one; missing lanes repeat the last batch with weight zero.
fn joined<const V: usize, const D: usize, const E: usize>(
    parts: &[Batch<V, D, E>],
) -> SingleBatch<V, D, E> {
    let nodes = |of: &dyn Fn(&Batch<V, D, E>) -> [u16; WIDTH]| -> [u16; SINGLE_WIDTH] {
        std::array::from_fn(|lane| of(part(parts, lane))[lane % WIDTH])
    };
    let number = |of: &dyn Fn(&Batch<V, D, E>) -> Lanes| -> Lanes<f32, SINGLE_WIDTH> {
        Lanes(std::array::from_fn(|lane| {
            f32::narrow(of(part(parts, lane)).0[lane % WIDTH])
        }))
    };
    let measure = |of: &dyn Fn(&Batch<V, D, E>) -> Lanes| {
        let mut numbers = number(of);
        numbers.0[WIDTH * parts.len()..].fill(0.0);
        numbers
    };
    Batch {
        vertices: std::array::from_fn(|a| nodes(&|batch| batch.vertices[a])),
        edges: std::array::from_fn(|e| nodes(&|batch| batch.edges[e])),
        gradients: std::array::from_fn(|a| {
            std::array::from_fn(|j| number(&|batch| batch.gradients[a][j]))
        }),
        shear: measure(&|batch| batch.shear),
        lame: measure(&|batch| batch.lame),
        augmented: measure(&|batch| batch.augmented),
        weight: measure(&|batch| batch.weight),
    }
}

/// The batch that a lane comes from, the last one after all.
fn part<const V: usize, const D: usize, const E: usize>(
    parts: &[Batch<V, D, E>],
    lane: usize,
) -> &Batch<V, D, E> {
    &parts[(lane / WIDTH).min(parts.len() - 1)]
}
