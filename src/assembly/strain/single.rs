//! Products with the tangents of whole cells in single precision, for preconditioners: that at
//! the centroid stands for those at the points, from which it differs by what the size of a cell
//! leaves. Tetrahedra. Memory: 250 bytes a cell. Cost of a product: some twice the linear one in
//! single precision.

use super::cell_tangents::CellTangents;
use crate::assembly::grid::{Basis, Grid, SingleCells};
use crate::assembly::kernel::{Batch, Element, Kernel, SYMMETRIC_ENTRIES};
use crate::assembly::lanes::{Lanes, SINGLE_WIDTH};
use crate::assembly::partition::blocks_of_cells;
use crate::assembly::simd::{BatchPass, prefetch_at};
use crate::assembly::transpose::{Row, Transpose};
use crate::linalg::{Held, ResidualUpdate, Workspace};
use crate::mesh::Mesh;
use crate::parallel;
use pulp::Simd;

/// A batch in single precision.
type SingleBatch = Batch<4, 3, 6, f32, SINGLE_WIDTH>;
/// The tangents of a batch, times the weight of a point.
type Tensors = [Lanes<f32, SINGLE_WIDTH>; SYMMETRIC_ENTRIES];

/// The tangent of a body, the identity on held unknowns.
#[derive(Clone, Debug)]
pub struct SingleTangent {
    cells: SingleCells<4, 3, 6>,
    /// Of each block, batch by batch.
    tensors: Vec<Vec<Tensors>>,
    basis: Basis,
    /// What is held.
    held: Held,
}

impl SingleTangent {
    /// Of the cells of `mesh`, which `grid` was made from; none in the plane.
    pub fn new(
        (mesh, grid): (&Mesh, &Grid),
        tangents: &CellTangents,
        basis: Basis,
        held: Held,
    ) -> Option<Self> {
        let Grid::Tetrahedra(grid) = grid else {
            return None;
        };
        let cells = SingleCells::new(grid);
        let blocks = blocks_of_cells(mesh);
        let of_block = |index: usize| {
            let batches = blocks[index].chunks(SINGLE_WIDTH).zip(cells.batches(index));
            let tensors = batches.map(|(batch, geometry)| tensors_of(batch, geometry, tangents));
            tensors.collect()
        };
        Some(Self {
            tensors: parallel::map(blocks.len(), 1, &of_block),
            cells,
            basis,
            held,
        })
    }

    /// Bytes held beside those of the grid.
    pub fn bytes(&self) -> u64 {
        let batches: usize = self.tensors.iter().map(Vec::len).sum();
        self.cells.bytes() + (batches * size_of::<Tensors>()) as u64
    }
}

/// The tangents of the cells of one batch; missing ones are zero.
fn tensors_of(cells: &[u32], geometry: &SingleBatch, tangents: &CellTangents) -> Tensors {
    std::array::from_fn(|entry| {
        let mut lanes = Lanes::zero();
        for (lane, &cell) in lanes.0.iter_mut().zip(cells) {
            *lane = tangents.tensors[cell as usize][entry] as f32;
        }
        for (lane, weight) in lanes.0.iter_mut().zip(&geometry.weight.0) {
            *lane *= weight;
        }
        lanes
    })
}

impl ResidualUpdate<f32> for SingleTangent {
    fn update_residual(&self, x: &[f32], r: &mut [f32], work: &mut Workspace) {
        let instructions = self.cells.instructions();
        self.cells
            .subtract(self.basis, (x, r), work, |block, x, y| {
                instructions.run(Pass {
                    batches: self.cells.batches(block),
                    tensors: &self.tensors[block],
                    x,
                    y,
                });
            });
        self.held.add_held(-1.0, x, r);
    }
}

/// Products on the batches of a block.
struct Pass<'a> {
    batches: &'a [SingleBatch],
    tensors: &'a [Tensors],
    x: &'a [Row<f32>],
    y: &'a mut [Row<f32>],
}

impl BatchPass for Pass<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd, T: Transpose>(self, simd: S, transpose: T) {
        let mut element = Element::zero();
        for (index, (batch, tensor)) in self.batches.iter().zip(self.tensors).enumerate() {
            prefetch_at(self.batches, index + 1);
            let kernel = Kernel {
                simd,
                transpose,
                batch,
                element: &mut element,
                x: self.x,
                y: &mut *self.y,
            };
            kernel.tangent(tensor);
        }
    }
}
