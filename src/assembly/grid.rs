//! The cells of a mesh as blocks of batches, and the passes over them.
//!
//! A pass gathers the nodes of each block into a local vector, runs a kernel on
//! its batches, and then sums the local results of each node in block order:
//! parallel over blocks, then over nodes, with bits that do not depend on the
//! number of threads. Memory: about 53 bytes per unknown.

use rayon::prelude::*;

use super::cells::{CellGeometry, CellModuli};
use super::kernel::Batch;
use super::lanes::{Lanes, WIDTH};
use super::partition::blocks_of_cells;
use super::simd::{self, InstructionSet};
use crate::linalg::Workspace;
use crate::mesh::Mesh;
use crate::space::TaylorHood;

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

/// A block: its nodes (vertices first), held entries, edge ends and batches.
#[derive(Clone, Debug)]
struct Block<const V: usize, const D: usize, const E: usize> {
    nodes: Vec<u32>,
    /// Local vertices precede local edges.
    vertices: usize,
    /// Local end vertices of each local edge.
    edge_ends: Vec<[u32; 2]>,
    /// Local indices of held entries.
    held: Vec<u32>,
    batches: Vec<Batch<V, D, E>>,
}

/// Where the copies of each node lie in the concatenated local vectors.
#[derive(Clone, Debug, Default)]
struct Copies {
    offsets: Vec<u32>,
    positions: Vec<u32>,
}

/// Blocks of one cell kind.
#[derive(Clone, Debug)]
pub struct CellGrid<const V: usize, const D: usize, const E: usize> {
    blocks: Vec<Block<V, D, E>>,
    copies: Copies,
    local_nodes: usize,
    instructions: InstructionSet,
}

/// The blocks of a mesh, by cell kind.
#[derive(Clone, Debug)]
pub enum Grid {
    /// Plane.
    Triangles(CellGrid<3, 2, 3>),
    /// Solid.
    Tetrahedra(CellGrid<4, 3, 6>),
}

impl Grid {
    /// Blocks of `mesh`; `held` are the ascending indices of held entries.
    pub fn new(
        mesh: &Mesh,
        space: &TaylorHood,
        geometry: &CellGeometry,
        moduli: &CellModuli,
        held: &[u32],
    ) -> Self {
        match geometry.vertices {
            3 => Self::Triangles(CellGrid::new(mesh, space, geometry, moduli, held)),
            _ => Self::Tetrahedra(CellGrid::new(mesh, space, geometry, moduli, held)),
        }
    }

    /// `y = A x` on all nodes.
    pub fn stiffness(
        &self,
        basis: Basis,
        rows: Rows,
        x: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
    ) {
        match self {
            Self::Triangles(grid) => grid.stiffness(basis, rows, x, y, work),
            Self::Tetrahedra(grid) => grid.stiffness(basis, rows, x, y, work),
        }
    }

    /// `r = B x`, hierarchical, `[vertices]`.
    pub fn divergence(&self, rows: Rows, x: &[f64], r: &mut [f64], work: &mut Workspace) {
        match self {
            Self::Triangles(grid) => grid.divergence(rows, x, r, work),
            Self::Tetrahedra(grid) => grid.divergence(rows, x, r, work),
        }
    }

    /// `y = B^T p`, hierarchical.
    pub fn divergence_transposed(
        &self,
        rows: Rows,
        p: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
    ) {
        match self {
            Self::Triangles(grid) => grid.divergence_transposed(rows, p, y, work),
            Self::Tetrahedra(grid) => grid.divergence_transposed(rows, p, y, work),
        }
    }

    /// The kernels that run here.
    pub fn instruction_set(&self) -> InstructionSet {
        match self {
            Self::Triangles(grid) => grid.instructions,
            Self::Tetrahedra(grid) => grid.instructions,
        }
    }

    /// The same cells with other kernels, to compare them.
    #[must_use]
    pub fn with_instruction_set(mut self, instructions: InstructionSet) -> Self {
        match &mut self {
            Self::Triangles(grid) => grid.instructions = instructions,
            Self::Tetrahedra(grid) => grid.instructions = instructions,
        }
        self
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Triangles(grid) => grid.bytes(),
            Self::Tetrahedra(grid) => grid.bytes(),
        }
    }
}

impl<const V: usize, const D: usize, const E: usize> CellGrid<V, D, E> {
    fn new(
        mesh: &Mesh,
        space: &TaylorHood,
        geometry: &CellGeometry,
        moduli: &CellModuli,
        held: &[u32],
    ) -> Self {
        let blocks: Vec<Block<V, D, E>> = blocks_of_cells(mesh)
            .par_iter()
            .map(|cells| Block::new(cells, mesh, space, geometry, moduli, held))
            .collect();
        let local_nodes = blocks.iter().map(|block| block.nodes.len()).sum();
        let copies = Copies::new(space.nodes(), blocks.iter().map(|block| &block.nodes[..]));
        Self {
            blocks,
            copies,
            local_nodes,
            instructions: InstructionSet::of_this_machine(),
        }
    }

    fn bytes(&self) -> u64 {
        let batch = size_of::<Batch<V, D, E>>() + (V + E) * size_of::<[u32; WIDTH]>();
        let blocks: usize = self
            .blocks
            .iter()
            .map(|b| batch * b.batches.len() + 4 * b.nodes.len() + 8 * b.edge_ends.len())
            .sum();
        (blocks + 4 * (self.copies.offsets.len() + self.copies.positions.len())) as u64
    }

    fn stiffness(&self, basis: Basis, rows: Rows, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.pass::<D, D>(x, y, work, |block, x, y| {
            block.prepare_argument(basis, rows, x);
            simd::stiffness(self.instructions, &block.batches, x, y);
            block.finish_result(basis, rows, y);
        });
    }

    fn divergence(&self, rows: Rows, x: &[f64], r: &mut [f64], work: &mut Workspace) {
        self.pass::<D, 1>(x, r, work, |block, x, r| {
            block.prepare_argument(Basis::Hierarchical, rows, x);
            simd::divergence(self.instructions, &block.batches, x, r);
        });
    }

    fn divergence_transposed(&self, rows: Rows, p: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.pass::<1, D>(p, y, work, |block, p, y| {
            simd::divergence_transposed(self.instructions, &block.batches, p, y);
            block.finish_result(Basis::Hierarchical, rows, y);
        });
    }

    /// One pass: `IN` components per node in, `OUT` out. Vectors shorter than
    /// all nodes end at the vertices.
    fn pass<const IN: usize, const OUT: usize>(
        &self,
        x: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
        run: impl Fn(&Block<V, D, E>, &mut [f64], &mut [f64]) + Sync,
    ) {
        let mut arguments = work.scratch(self.local_nodes * IN);
        let mut results = work.zeros(self.local_nodes * OUT);
        let given = (x.len() / IN) as u32;
        self.split::<IN, OUT>(&mut arguments, &mut results)
            .into_par_iter()
            .for_each(|(block, local_x, local_y)| {
                gather_nodes::<IN>(&block.nodes, given, x, local_x);
                run(block, local_x, local_y);
            });
        self.copies.sum::<OUT>(&results, y);
        work.give(arguments);
        work.give(results);
    }

    #[allow(clippy::type_complexity)]
    fn split<'a, const IN: usize, const OUT: usize>(
        &'a self,
        mut arguments: &'a mut [f64],
        mut results: &'a mut [f64],
    ) -> Vec<(&'a Block<V, D, E>, &'a mut [f64], &'a mut [f64])> {
        let mut pieces = Vec::with_capacity(self.blocks.len());
        for block in &self.blocks {
            let (x, x_rest) = arguments.split_at_mut(block.nodes.len() * IN);
            let (y, y_rest) = results.split_at_mut(block.nodes.len() * OUT);
            pieces.push((block, x, y));
            (arguments, results) = (x_rest, y_rest);
        }
        pieces
    }
}

fn gather_nodes<const C: usize>(nodes: &[u32], given: u32, x: &[f64], local: &mut [f64]) {
    let (targets, _) = local.as_chunks_mut::<C>();
    let (sources, _) = x.as_chunks::<C>();
    for (target, &node) in targets.iter_mut().zip(nodes) {
        if node < given {
            *target = sources[node as usize];
        } else {
            *target = [0.0; C];
        }
    }
}

impl Copies {
    fn new<'a>(nodes: usize, blocks: impl Iterator<Item = &'a [u32]> + Clone) -> Self {
        let mut offsets = vec![0_u32; nodes + 1];
        for node in blocks.clone().flatten() {
            offsets[*node as usize + 1] += 1;
        }
        for node in 0..nodes {
            offsets[node + 1] += offsets[node];
        }
        let mut next = offsets.clone();
        let mut positions = vec![0; offsets[nodes] as usize];
        for (position, node) in blocks.flatten().enumerate() {
            let slot = &mut next[*node as usize];
            positions[*slot as usize] = position as u32;
            *slot += 1;
        }
        Self { offsets, positions }
    }

    fn sum<const C: usize>(&self, local: &[f64], y: &mut [f64]) {
        const PIECE: usize = 2048;
        let (values, _) = local.as_chunks::<C>();
        y.par_chunks_mut(PIECE * C)
            .enumerate()
            .for_each(|(piece, part)| {
                let (nodes, _) = part.as_chunks_mut::<C>();
                for (index, target) in nodes.iter_mut().enumerate() {
                    let node = piece * PIECE + index;
                    let range = self.offsets[node] as usize..self.offsets[node + 1] as usize;
                    let mut sum = [0.0; C];
                    for &position in &self.positions[range] {
                        for i in 0..C {
                            sum[i] += values[position as usize][i];
                        }
                    }
                    *target = sum;
                }
            });
    }
}

impl<const V: usize, const D: usize, const E: usize> Block<V, D, E> {
    fn new(
        cells: &[u32],
        mesh: &Mesh,
        space: &TaylorHood,
        geometry: &CellGeometry,
        moduli: &CellModuli,
        held: &[u32],
    ) -> Self {
        let cell_nodes: Vec<Vec<u32>> = cells
            .iter()
            .map(|&cell| nodes_of_cell::<V, E>(mesh, space, cell as usize))
            .collect();
        let mut nodes: Vec<u32> = cell_nodes.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let local = |node: u32| nodes.partition_point(|&other| other < node) as u32;
        let vertices = nodes.partition_point(|&node| (node as usize) < space.vertices);
        let edge_ends = nodes[vertices..]
            .iter()
            .map(|&node| space.edges[node as usize - space.vertices].map(local))
            .collect();
        let held = nodes
            .iter()
            .enumerate()
            .flat_map(|(index, &node)| (0..D as u32).map(move |i| (index as u32, node, i)))
            .filter(|&(_, node, i)| held.binary_search(&(node * D as u32 + i)).is_ok())
            .map(|(index, _, i)| index * D as u32 + i)
            .collect();
        let batches = cells
            .chunks(WIDTH)
            .zip(cell_nodes.chunks(WIDTH))
            .map(|(cells, cell_nodes)| batch(cells, cell_nodes, geometry, moduli, &local))
            .collect();
        Self {
            nodes,
            vertices,
            edge_ends,
            held,
            batches,
        }
    }

    fn mask(&self, rows: Rows, x: &mut [f64]) {
        if rows == Rows::Free {
            for &index in &self.held {
                x[index as usize] = 0.0;
            }
        }
    }

    fn prepare_argument(&self, basis: Basis, rows: Rows, x: &mut [f64]) {
        self.mask(rows, x);
        if basis == Basis::Lagrange {
            self.for_edges(|edge, a, b| x[edge] -= 0.5 * (x[a] + x[b]));
        }
    }

    fn finish_result(&self, basis: Basis, rows: Rows, y: &mut [f64]) {
        if basis == Basis::Lagrange {
            self.for_edges(|edge, a, b| {
                let half = 0.5 * y[edge];
                y[a] -= half;
                y[b] -= half;
            });
        }
        self.mask(rows, y);
    }

    fn for_edges(&self, mut visit: impl FnMut(usize, usize, usize)) {
        for (edge, ends) in self.edge_ends.iter().enumerate() {
            for i in 0..D {
                visit(
                    (self.vertices + edge) * D + i,
                    ends[0] as usize * D + i,
                    ends[1] as usize * D + i,
                );
            }
        }
    }
}

/// Node numbers of a cell: vertices, then edges.
pub fn nodes_of_cell<const V: usize, const E: usize>(
    mesh: &Mesh,
    space: &TaylorHood,
    cell: usize,
) -> Vec<u32> {
    let vertices = mesh.cells()[cell * V..(cell + 1) * V].iter().copied();
    let edges = mesh.cell_edges()[cell * E..(cell + 1) * E]
        .iter()
        .map(|&edge| edge + space.vertices as u32);
    vertices.chain(edges).collect()
}

/// A batch of up to eight cells; missing lanes repeat the last cell with
/// weight zero.
fn batch<const V: usize, const D: usize, const E: usize>(
    cells: &[u32],
    cell_nodes: &[Vec<u32>],
    geometry: &CellGeometry,
    moduli: &CellModuli,
    local: &impl Fn(u32) -> u32,
) -> Batch<V, D, E> {
    let mut out = Batch {
        nodes: vec![[0; WIDTH]; V + E],
        gradients: [[Lanes::ZERO; D]; D],
        shear: Lanes::ZERO,
        lame: Lanes::ZERO,
        weight: Lanes::ZERO,
    };
    for lane in 0..WIDTH {
        let source = lane.min(cells.len() - 1);
        let cell = cells[source] as usize;
        for (slot, &node) in out.nodes.iter_mut().zip(&cell_nodes[source]) {
            slot[lane] = local(node);
        }
        for a in 0..D {
            for j in 0..D {
                out.gradients[a][j].0[lane] = geometry.gradients_of(cell)[a + 1][j];
            }
        }
        if lane < cells.len() {
            let weight = geometry.volumes[cell] / V as f64;
            out.weight.0[lane] = weight;
            out.shear.0[lane] = weight * moduli.shear[cell];
            out.lame.0[lane] = weight * moduli.lame[cell];
        }
    }
    out
}
