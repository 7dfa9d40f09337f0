//! The cells of a mesh as blocks of batches, and the passes over them.
//!
//! A pass gathers the nodes of each block into rows of its own, runs a kernel
//! on its batches, and then sums the copies of each node in block order:
//! parallel over groups of blocks, then over nodes, with bits that do not depend
//! on the number of threads. The groups are fixed by the mesh. Memory: about 40
//! bytes per unknown, and as much scratch.

mod block;
mod copies;
mod single;

use crate::parallel::{self, Pieces};
use std::sync::Arc;

use super::kernel::{Batch, PRESSURE};
use super::lanes::Lanes;
use super::partition::blocks_of_cells;
use super::simd::{self, InstructionSet};
use super::strain::{Curve, Terms};
use super::transpose::Row;
use crate::linalg::{Scalar, Workspace};
pub(super) use block::Block;
pub use block::GridSource;
pub(super) use copies::Copies;
pub use single::{SingleCells, SingleGrid};

/// Most groups of blocks that run at the same time.
const MOST_GROUPS: usize = 64;
/// Rows of results that a pass over cells of so many vertices needs for a second thread to be worth
/// its waking.
const fn alone(vertices: usize) -> usize {
    match vertices {
        3 => 8192,
        _ => 4096,
    }
}

/// The basis of a displacement vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// Vertex values and edge corrections.
    Hierarchical,
    /// Values at vertices and edge midpoints.
    Lagrange,
}

/// Whether held unknowns are eliminated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// Held entries of the argument count as zero; held rows are left zero.
    Free,
    /// All entries take part: loads and reactions.
    All,
}

/// Which resistance to changes of volume a product holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VolumeTerm {
    /// That of the displacement block.
    Own,
    /// That of its approximate inverse, on straight cells.
    Augmented,
}

/// A product with the stiffness.
#[derive(Clone, Copy, Debug)]
pub struct StiffnessForm {
    /// Basis of argument and result.
    pub basis: Basis,
    /// Which rows are left alone.
    pub rows: Rows,
    /// Resistance to changes of volume.
    pub volume: VolumeTerm,
}

/// Blocks of one cell kind.
#[derive(Clone, Debug)]
pub struct CellGrid<const V: usize, const D: usize, const E: usize> {
    blocks: Vec<Block<V, D, E>>,
    /// Blocks per group; groups run in parallel, a group's blocks one by one.
    group: usize,
    /// Most nodes of a block.
    block_rows: usize,
    /// Most rows of the results of a group.
    group_rows: usize,
    copies: Copies,
    instructions: InstructionSet,
}

/// The blocks of a mesh, by cell kind.
#[derive(Clone, Debug)]
pub enum Grid {
    /// Plane.
    Triangles(Arc<CellGrid<3, 2, 3>>),
    /// Solid.
    Tetrahedra(Arc<CellGrid<4, 3, 6>>),
}

/// The same call on either cell kind.
macro_rules! either {
    ($either:expr, $grid:ident => $call:expr) => {
        match $either {
            Grid::Triangles($grid) => $call,
            Grid::Tetrahedra($grid) => $call,
        }
    };
}

impl Grid {
    /// Blocks of the cells of `source`.
    pub fn new(source: GridSource<'_>) -> Self {
        match source.geometry.vertices {
            3 => Self::Triangles(Arc::new(CellGrid::new(source))),
            _ => Self::Tetrahedra(Arc::new(CellGrid::new(source))),
        }
    }

    /// `y = A x` on all nodes.
    pub fn stiffness(&self, form: StiffnessForm, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        either!(self, grid => grid.stiffness(form, x, y, work));
    }

    /// `r -= A x` on all nodes, held entries of both left out.
    pub fn subtract_stiffness(
        &self,
        (basis, volume): (Basis, VolumeTerm),
        x: &[f64],
        r: &mut [f64],
        work: &mut Workspace,
    ) {
        either!(self, grid => grid.subtract_stiffness((basis, volume), x, r, work));
    }

    /// `r = B x`, hierarchical, `[vertices]`.
    pub fn divergence(&self, rows: Rows, x: &[f64], r: &mut [f64], work: &mut Workspace) {
        either!(self, grid => grid.divergence(rows, x, r, work));
    }

    /// `y = B^T p`, hierarchical.
    pub fn divergence_transposed(
        &self,
        rows: Rows,
        p: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
    ) {
        either!(self, grid => grid.divergence_transposed(rows, p, y, work));
    }

    /// `y += factor B^T p`, hierarchical, held rows left alone.
    pub fn add_divergence_transposed(
        &self,
        factor: f64,
        p: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
    ) {
        either!(self, grid => grid.add_divergence_transposed(factor, p, y, work));
    }

    /// `(y, r) = (A u + B^T p, B u)`, hierarchical, held entries left out, for
    /// the price of `A u`.
    pub fn saddle(
        &self,
        (u, p): (&[f64], &[f64]),
        (y, r): (&mut [f64], &mut [f64]),
        work: &mut Workspace,
    ) {
        either!(self, grid => grid.saddle((u, p), (y, r), work));
    }

    /// Whether the cells are sections of a body of revolution about x = 0.
    pub fn is_about_axis(&self) -> bool {
        either!(self, grid => grid.blocks.iter().any(|block| !block.radii.is_empty()))
    }

    /// The kernels that run here.
    pub fn instruction_set(&self) -> InstructionSet {
        either!(self, grid => grid.instructions)
    }

    /// The same cells with other kernels, to compare them.
    #[must_use]
    pub fn with_instruction_set(mut self, instructions: InstructionSet) -> Self {
        either!(&mut self, grid => Arc::make_mut(grid).instructions = instructions);
        self
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        either!(self, grid => grid.bytes())
    }
}

impl<const V: usize, const D: usize, const E: usize> CellGrid<V, D, E> {
    fn new(source: GridSource<'_>) -> Self {
        let cells = blocks_of_cells(source.mesh);
        let block = |k: usize| Block::new(&cells[k], source);
        let blocks: Vec<Block<V, D, E>> = parallel::map(cells.len(), 1, &block);
        let group = blocks.len().div_ceil(MOST_GROUPS).max(1);
        let rows = |group: &[Block<V, D, E>]| group.iter().map(|b| b.nodes.len()).sum();
        let group_rows: usize = blocks.chunks(group).map(rows).max().unwrap_or(0);
        let mut firsts = Vec::with_capacity(blocks.len());
        for (index, group) in blocks.chunks(group).enumerate() {
            let mut first = index * group_rows;
            for block in group {
                firsts.push(first);
                first += block.nodes.len();
            }
        }
        let placed = firsts.iter().zip(&blocks);
        let copies = Copies::new(
            source.space.nodes(),
            placed.map(|(&first, block)| (first, &block.nodes[..])),
        );
        Self {
            block_rows: blocks.iter().map(|b| b.nodes.len()).max().unwrap_or(0),
            blocks,
            group,
            group_rows,
            copies,
            instructions: InstructionSet::of_this_machine(),
        }
    }

    fn bytes(&self) -> u64 {
        let blocks: usize = self.blocks.iter().map(Block::bytes).sum();
        (blocks + self.copies.bytes()) as u64
    }

    fn stiffness(&self, form: StiffnessForm, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.stiffness_into(form, x, work, |local| {
            self.copies.sum::<D, f64>(local, y, set_displacement);
        });
    }

    fn subtract_stiffness(
        &self,
        (basis, volume): (Basis, VolumeTerm),
        x: &[f64],
        r: &mut [f64],
        work: &mut Workspace,
    ) {
        let form = StiffnessForm {
            basis,
            rows: Rows::Free,
            volume,
        };
        self.stiffness_into(form, x, work, |local| {
            self.copies.sum::<D, f64>(local, r, add_displacement(-1.0));
        });
    }

    fn stiffness_into(
        &self,
        form: StiffnessForm,
        x: &[f64],
        work: &mut Workspace,
        finish: impl FnOnce(&[Row]),
    ) {
        let StiffnessForm {
            basis,
            rows,
            volume,
        } = form;
        self.pass(
            work,
            |block, x_rows| {
                block.gather_displacement(x, x_rows);
                block.prepare_argument(basis, rows, x_rows);
            },
            |_, block, x, y| {
                match volume {
                    VolumeTerm::Own => {
                        simd::stiffness(self.instructions, block.straight(), x, y);
                        block.add_by_points((self.instructions, Terms::Saddle), x, y);
                    }
                    VolumeTerm::Augmented => {
                        simd::augmented_stiffness(self.instructions, &block.batches, x, y);
                    }
                }
                block.finish_result(basis, rows, y);
            },
            finish,
        );
    }

    fn add_divergence_transposed(
        &self,
        factor: f64,
        p: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
    ) {
        self.pass(
            work,
            |block, p_rows| block.gather_pressure(p, p_rows),
            |_, block, p, y| {
                simd::divergence_transposed(self.instructions, block.straight(), p, y);
                block.add_by_points((self.instructions, Terms::Pressure), p, y);
                block.finish_result(Basis::Hierarchical, Rows::Free, y);
            },
            |local| {
                self.copies
                    .sum::<D, f64>(local, y, add_displacement(factor))
            },
        );
    }

    fn divergence(&self, rows: Rows, x: &[f64], r: &mut [f64], work: &mut Workspace) {
        self.pass(
            work,
            |block, x_rows| {
                block.gather_displacement(x, x_rows);
                block.prepare_argument(Basis::Hierarchical, rows, x_rows);
            },
            |_, block, x, r| {
                simd::divergence(self.instructions, block.straight(), x, r);
                block.add_by_points((self.instructions, Terms::Saddle), x, r);
            },
            |local| self.copies.sum::<1, f64>(local, r, set_pressure),
        );
    }

    fn divergence_transposed(&self, rows: Rows, p: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.pass(
            work,
            |block, p_rows| block.gather_pressure(p, p_rows),
            |_, block, p, y| {
                simd::divergence_transposed(self.instructions, block.straight(), p, y);
                block.add_by_points((self.instructions, Terms::Pressure), p, y);
                block.finish_result(Basis::Hierarchical, rows, y);
            },
            |local| self.copies.sum::<D, f64>(local, y, set_displacement),
        );
    }

    fn saddle(
        &self,
        (u, p): (&[f64], &[f64]),
        (y, r): (&mut [f64], &mut [f64]),
        work: &mut Workspace,
    ) {
        self.pass(
            work,
            |block, x_rows| {
                block.gather_displacement(u, x_rows);
                block.prepare_argument(Basis::Hierarchical, Rows::Free, x_rows);
                block.gather_pressure(p, x_rows);
            },
            |_, block, x, y| {
                simd::saddle(self.instructions, block.straight(), x, y);
                block.add_by_points((self.instructions, Terms::Saddle), x, y);
                block.finish_result(Basis::Hierarchical, Rows::Free, y);
            },
            |local| {
                self.copies.sum::<D, f64>(local, y, set_displacement);
                self.copies.sum::<1, f64>(local, r, set_pressure);
            },
        );
    }

    /// Curved edges of the last batches of a block.
    pub(super) fn curves(&self, block: usize) -> &[Curve<V, D, E>] {
        &self.blocks[block].curves
    }

    /// Radii of the vertices of a block, batch by batch; empty where the body is not one of
    /// revolution.
    pub(super) fn radii(&self, block: usize) -> &[Lanes] {
        &self.blocks[block].radii
    }

    /// Batches of a block.
    pub(super) fn batches(&self, block: usize) -> &[Batch<V, D, E>] {
        &self.blocks[block].batches
    }

    /// The kernels that run here.
    pub(super) fn instructions(&self) -> InstructionSet {
        self.instructions
    }

    /// Where the results of blocks belong.
    pub(super) fn copies(&self) -> &Copies {
        &self.copies
    }

    /// One pass: `gather` fills the rows of a block, `run` adds to its results,
    /// `finish` takes the results of all blocks.
    pub(super) fn pass<R: Scalar>(
        &self,
        work: &mut Workspace,
        gather: impl Fn(&Block<V, D, E>, &mut [Row<R>]) + Sync,
        run: impl Fn(usize, &Block<V, D, E>, &[Row<R>], &mut [Row<R>]) + Sync,
        finish: impl FnOnce(&[Row<R>]),
    ) {
        // Items without size take no memory.
        let mut nothing = vec![(); self.blocks.len()];
        let run =
            |index: usize, block: &Block<V, D, E>, _: &mut (), x: &[Row<R>], y: &mut [Row<R>]| {
                run(index, block, x, y);
            };
        self.pass_over(&mut nothing, work, gather, run, finish);
    }

    /// [`Self::pass`] that also changes an item of each block.
    pub(super) fn pass_over<I: Send, R: Scalar>(
        &self,
        items: &mut [I],
        work: &mut Workspace,
        gather: impl Fn(&Block<V, D, E>, &mut [Row<R>]) + Sync,
        run: impl Fn(usize, &Block<V, D, E>, &mut I, &[Row<R>], &mut [Row<R>]) + Sync,
        finish: impl FnOnce(&[Row<R>]),
    ) {
        let groups = self.blocks.len().div_ceil(self.group);
        // A group's argument is one block's, and so stays in its cache.
        let mut arguments = R::take(work, 4 * groups * self.block_rows);
        let mut results = R::take(work, 4 * groups * self.group_rows);
        let (argument_rows, _) = arguments.as_chunks_mut::<4>();
        let (result_rows, _) = results.as_chunks_mut::<4>();
        let of_group = |number: usize, items: &mut [I], x: &mut [Row<R>], mut y: &mut [Row<R>]| {
            let group = self.blocks[number * self.group..].iter().zip(items);
            for (offset, (block, item)) in group.enumerate() {
                let x = &mut x[..block.nodes.len()];
                let (y_block, rest) = y.split_at_mut(block.nodes.len());
                gather(block, x);
                y_block.fill([R::default(); 4]);
                run(number * self.group + offset, block, item, x, y_block);
                y = rest;
            }
        };
        let (own, each) = (self.block_rows.max(1), self.group_rows.max(1));
        let least = (alone(V) / each).div_ceil(2).max(1);
        let rows = [
            Pieces::of(argument_rows, own),
            Pieces::of(result_rows, each),
        ];
        let items = Pieces::of(items, self.group);
        parallel::each_of_three(items, rows, least, &|number, items, [x, y]| {
            of_group(number, items, x, y);
        });
        finish(result_rows);
        R::give(work, arguments);
        R::give(work, results);
    }
}

pub(super) fn set_displacement<const D: usize>(target: &mut [f64; D], sum: Row) {
    target.copy_from_slice(&sum[..D]);
}

pub(super) fn add_displacement<const D: usize>(factor: f64) -> impl Fn(&mut [f64; D], Row) + Sync {
    move |target, sum| {
        for i in 0..D {
            target[i] += factor * sum[i];
        }
    }
}

pub(super) fn set_pressure(target: &mut [f64; 1], sum: Row) {
    target[0] = sum[PRESSURE];
}
