//! Products with A in single precision, for preconditioners: half the bytes, sixteen cells at a
//! time. Nodes, ends of edges and held entries are those of the grid in double precision; cells
//! and order of sums are the same. Memory: 68 bytes a tetrahedron.

use std::sync::Arc;

use rayon::prelude::*;

use super::{Basis, CellGrid, Grid, Rows};
use crate::assembly::kernel::Batch;
use crate::assembly::lanes::{Lanes, SINGLE_WIDTH, WIDTH};
use crate::assembly::simd;
use crate::linalg::{Scalar, Workspace};

/// Batches in double precision that one in single precision holds.
const PAIR: usize = SINGLE_WIDTH / WIDTH;

/// One batch in single precision.
type SingleBatch<const V: usize, const D: usize, const E: usize> =
    Batch<V, D, E, f32, SINGLE_WIDTH>;

/// The cells of each block of a grid.
#[derive(Clone, Debug)]
enum Cells {
    Triangles(Vec<Vec<SingleBatch<3, 2, 3>>>),
    Tetrahedra(Vec<Vec<SingleBatch<4, 3, 6>>>),
}

/// A grid whose cells are known in single precision too.
#[derive(Clone, Debug)]
pub struct SingleGrid {
    grid: Arc<Grid>,
    cells: Cells,
}

impl SingleGrid {
    /// The cells of `grid`, rounded.
    pub fn new(grid: Arc<Grid>) -> Self {
        let cells = match &*grid {
            Grid::Triangles(grid) => Cells::Triangles(rounded(grid)),
            Grid::Tetrahedra(grid) => Cells::Tetrahedra(rounded(grid)),
        };
        Self { grid, cells }
    }

    /// `r -= A x` on all nodes, held entries of both left out.
    pub fn subtract_stiffness(&self, basis: Basis, x: &[f32], r: &mut [f32], work: &mut Workspace) {
        match (&*self.grid, &self.cells) {
            (Grid::Triangles(grid), Cells::Triangles(cells)) => {
                subtract(grid, cells, basis, (x, r), work);
            }
            (Grid::Tetrahedra(grid), Cells::Tetrahedra(cells)) => {
                subtract(grid, cells, basis, (x, r), work);
            }
            (Grid::Triangles(_), Cells::Tetrahedra(_))
            | (Grid::Tetrahedra(_), Cells::Triangles(_)) => {}
        }
    }

    /// Bytes held beside those of the grid.
    pub fn bytes(&self) -> u64 {
        let count = |blocks: usize, size: usize| (blocks * size) as u64;
        match &self.cells {
            Cells::Triangles(blocks) => count(
                blocks.iter().map(Vec::len).sum(),
                size_of::<SingleBatch<3, 2, 3>>(),
            ),
            Cells::Tetrahedra(blocks) => count(
                blocks.iter().map(Vec::len).sum(),
                size_of::<SingleBatch<4, 3, 6>>(),
            ),
        }
    }
}

fn subtract<const V: usize, const D: usize, const E: usize>(
    grid: &CellGrid<V, D, E>,
    cells: &[Vec<SingleBatch<V, D, E>>],
    basis: Basis,
    (x, r): (&[f32], &mut [f32]),
    work: &mut Workspace,
) {
    grid.pass(
        work,
        |block, x_rows| {
            block.gather_displacement(x, x_rows);
            block.prepare_argument(basis, Rows::Free, x_rows);
        },
        |index, block, x, y| {
            simd::stiffness(grid.instructions, &cells[index], x, y);
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

/// The batches of all blocks in single precision.
fn rounded<const V: usize, const D: usize, const E: usize>(
    grid: &CellGrid<V, D, E>,
) -> Vec<Vec<SingleBatch<V, D, E>>> {
    let blocks = grid.blocks.par_iter();
    let of_block = |batches: &[Batch<V, D, E>]| batches.chunks(PAIR).map(joined).collect();
    blocks.map(|block| of_block(&block.batches)).collect()
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
        weight: measure(&|batch| batch.weight),
    }
}

/// The batch that a lane comes from, the last one behind all.
fn part<const V: usize, const D: usize, const E: usize>(
    parts: &[Batch<V, D, E>],
    lane: usize,
) -> &Batch<V, D, E> {
    &parts[(lane / WIDTH).min(parts.len() - 1)]
}
