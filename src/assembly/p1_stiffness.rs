//! The assembled P1 block A11 = P^T A P and the node blocks of the P2
//! stiffness in the Lagrange basis.
//!
//! For barycentric gradients g_a: int 2 mu eps:eps + lambda div div couples
//! vertices a and b by mu (g_a.g_b I + g_b g_a^T) + lambda g_a g_b^T, times the
//! volume. Held components have identity rows and columns.

use super::cells::{CellGeometry, CellModuli};
use crate::linalg::Held;
use crate::linalg::cholesky::LowerColumns;
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// A coupling of two nodes; in two dimensions the last row and column are not read.
pub type Block = [[f64; 3]; 3];

/// A stiffness that is constant on each cell.
pub trait CellStiffness: Sync {
    /// Coupling of gradients `a` (rows) and `b` (columns) for unit volume; its transpose where
    /// they change places.
    fn coupling(&self, cell: usize, a: &[f64; 3], b: &[f64; 3]) -> Block;
    /// Shear modulus.
    fn shear(&self, cell: usize) -> f64;
}

/// That of the approximate inverse.
impl CellStiffness for CellModuli {
    fn coupling(&self, cell: usize, a: &[f64; 3], b: &[f64; 3]) -> Block {
        coupling(self.shear[cell], self.augmented[cell], a, b)
    }

    fn shear(&self, cell: usize) -> f64 {
        self.shear[cell]
    }
}

/// Coupling of gradients `a` and `b` for unit volume.
pub fn coupling(shear: f64, lame: f64, a: &[f64; 3], b: &[f64; 3]) -> Block {
    let product = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let mut block = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            block[i][j] = shear * a[j] * b[i] + lame * a[i] * b[j];
        }
        block[i][i] += shear * product;
    }
    block
}

/// The coupling the other way round.
fn transposed(block: &Block) -> Block {
    std::array::from_fn(|i| std::array::from_fn(|j| block[j][i]))
}

/// Adds `factor` times a block to another.
pub fn add(target: &mut Block, factor: f64, block: &Block) {
    for i in 0..3 {
        for j in 0..3 {
            target[i][j] += factor * block[i][j];
        }
    }
}

/// A11 by vertices and edges, held components not yet eliminated.
#[derive(Clone, Debug)]
pub struct P1Blocks {
    /// Diagonal block of each vertex.
    pub diagonal: Vec<Block>,
    /// Block of each edge: rows of the lower end, columns of the upper one.
    pub off: Vec<Block>,
}

/// Stiffness of held directions, over that of the node, where inverse blocks are to let nothing
/// through: 1e-8 of a free motion, above the rounding of a block.
pub const RIGID: f64 = 1e8;

/// Couplings of nodes where directions of some are held: P A P + s (1 - P), s `stiffness` times the
/// largest entry of the node. `off` are the blocks of `pairs`, rows of the lower end.
pub fn project_couplings(
    held: &Held,
    diagonal: &mut [Block],
    (pairs, off): (&[[u32; 2]], &mut [Block]),
    stiffness: f64,
) {
    if held.nodes.is_empty() {
        return;
    }
    let found = |node: u32| {
        let place = held.nodes.binary_search_by_key(&node, |one| one.node);
        place.ok().map(|place| &held.nodes[place])
    };
    for (pair, block) in pairs.iter().zip(off) {
        if let Some(column) = found(pair[1]) {
            block.iter_mut().for_each(|row| column.project(row));
        }
        if let Some(row) = found(pair[0]) {
            let mut turned = transposed(block);
            turned.iter_mut().for_each(|column| row.project(column));
            *block = transposed(&turned);
        }
    }
    for one in held.nodes.iter() {
        if let Some(block) = diagonal.get_mut(one.node as usize) {
            let block = block.as_flattened_mut();
            let largest = block.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            one.project_block(block, 3, stiffness * largest);
        }
    }
}

/// Cells and the stiffness of each.
#[derive(Clone, Copy)]
pub struct StiffCells<'a> {
    /// Mesh.
    pub mesh: &'a Mesh,
    /// Numbering.
    pub space: &'a TaylorHood,
    /// Gradients and volumes.
    pub geometry: &'a CellGeometry,
    /// Stiffness.
    pub stiffness: &'a dyn CellStiffness,
}

/// Couplings of one cell for unit volume; those of a triangle leave the last ones out.
struct Couplings {
    /// Of each vertex with itself.
    vertices: [Block; 4],
    /// Of the first end of each edge (rows) with the second.
    edges: [Block; 6],
}

impl StiffCells<'_> {
    fn couplings(&self, cell: usize) -> Couplings {
        let g = self.geometry.gradients_of(cell);
        let mut out = Couplings {
            vertices: [[[0.0; 3]; 3]; 4],
            edges: [[[0.0; 3]; 3]; 6],
        };
        for (block, g) in out.vertices.iter_mut().zip(g) {
            *block = self.stiffness.coupling(cell, g, g);
        }
        let pairs = self.mesh.cell_kind().edges();
        for (block, &(a, b)) in out.edges.iter_mut().zip(pairs) {
            *block = self.stiffness.coupling(cell, &g[a], &g[b]);
        }
        out
    }

    /// A11 by blocks. `shift` adds a multiple of the lumped mass, for bodies whose
    /// supports leave rigid modes.
    pub fn p1_blocks(&self, shift: f64) -> P1Blocks {
        let Self {
            mesh,
            space,
            geometry,
            stiffness,
        } = *self;
        let mut diagonal = vec![[[0.0; 3]; 3]; space.vertices];
        let mut off = vec![[[0.0; 3]; 3]; space.edges.len()];
        let vertices = geometry.vertices;
        let pairs = mesh.cell_kind().edges();
        for cell in 0..geometry.cells() {
            let volume = geometry.volumes[cell];
            let corners = &mesh.cells()[cell * vertices..(cell + 1) * vertices];
            let couplings = self.couplings(cell);
            for (own, &vertex) in couplings.vertices.iter().zip(corners) {
                let block = &mut diagonal[vertex as usize];
                add(block, volume, own);
                for (i, row) in block.iter_mut().enumerate() {
                    row[i] += shift * stiffness.shear(cell) * volume / vertices as f64;
                }
            }
            for (local, (&(a, b), block)) in pairs.iter().zip(&couplings.edges).enumerate() {
                let edge = mesh.cell_edges()[cell * pairs.len() + local] as usize;
                if corners[a] < corners[b] {
                    add(&mut off[edge], volume, block)
                } else {
                    add(&mut off[edge], volume, &transposed(block))
                }
            }
        }
        P1Blocks { diagonal, off }
    }

    /// Diagonal blocks of the P2 stiffness on Lagrange nodes
    /// `[nodes, components, components]`, identity for held components.
    pub fn node_blocks(&self, held: &Held) -> Vec<f64> {
        let Self {
            mesh,
            space,
            geometry,
            ..
        } = *self;
        let vertices = geometry.vertices;
        let pairs = mesh.cell_kind().edges();
        let d = (vertices - 1) as f64;
        // Means over the cell of (4 l - 1)^2, l_a^2 and l_a l_b.
        let square = 2.0 / ((d + 1.0) * (d + 2.0));
        let mixed = 0.5 * square;
        let corner = 16.0 * square - 8.0 / (d + 1.0) + 1.0;
        let mut blocks = vec![[[0.0; 3]; 3]; space.nodes()];
        for cell in 0..geometry.cells() {
            let volume = geometry.volumes[cell];
            let couplings = self.couplings(cell);
            let corners = &mesh.cells()[cell * vertices..(cell + 1) * vertices];
            for (own, &vertex) in couplings.vertices.iter().zip(corners) {
                add(&mut blocks[vertex as usize], volume * corner, own);
            }
            for (local, (&(a, b), both)) in pairs.iter().zip(&couplings.edges).enumerate() {
                let edge = mesh.cell_edges()[cell * pairs.len() + local] as usize;
                let block = &mut blocks[space.vertices + edge];
                add(block, 16.0 * volume * square, &couplings.vertices[a]);
                add(block, 16.0 * volume * square, &couplings.vertices[b]);
                add(block, 16.0 * volume * mixed, both);
                add(block, 16.0 * volume * mixed, &transposed(both));
            }
        }
        flatten(&blocks, space.components, held)
    }
}

impl P1Blocks {
    /// The lower triangle, unknowns vertex by vertex, with identity rows and columns at `held` unknowns.
    pub fn lower_columns(&self, space: &TaylorHood, held: &[u32]) -> LowerColumns {
        lower_columns(space, &self.diagonal, &self.off, held)
    }
}

fn lower_columns(
    space: &TaylorHood,
    diagonal: &[Block],
    off: &[Block],
    held: &[u32],
) -> LowerColumns {
    let c = space.components;
    let mut is_held = vec![false; space.vertices * c];
    for &index in held {
        if let Some(flag) = is_held.get_mut(index as usize) {
            *flag = true;
        }
    }
    let mut matrix = LowerColumns {
        offsets: vec![0],
        ..LowerColumns::default()
    };
    let mut edge = 0;
    for vertex in 0..space.vertices {
        let first = edge;
        while edge < space.edges.len() && space.edges[edge][0] as usize == vertex {
            edge += 1;
        }
        for j in 0..c {
            let column = vertex * c + j;
            let mut push = |row: usize, value: f64| {
                let identity = is_held[row] || is_held[column];
                matrix.rows.push(row as u32);
                matrix.values.push(match (identity, row == column) {
                    (false, _) => value,
                    (true, true) => 1.0,
                    (true, false) => 0.0,
                });
            };
            for i in j..c {
                push(vertex * c + i, diagonal[vertex][i][j]);
            }
            for (ends, block) in space.edges[first..edge].iter().zip(&off[first..edge]) {
                for i in 0..c {
                    push(ends[1] as usize * c + i, block[j][i]);
                }
            }
            matrix.offsets.push(matrix.rows.len() as u32);
        }
    }
    matrix
}

fn flatten(blocks: &[Block], components: usize, held: &Held) -> Vec<f64> {
    let size = components * components;
    let mut flat = Vec::with_capacity(blocks.len() * size);
    for block in blocks {
        for row in &block[..components] {
            flat.extend_from_slice(&row[..components]);
        }
    }
    for &index in held.entries.iter() {
        let (node, i) = (index as usize / components, index as usize % components);
        let block = &mut flat[node * size..(node + 1) * size];
        for j in 0..components {
            block[i * components + j] = 0.0;
            block[j * components + i] = 0.0;
        }
        block[i * components + i] = 1.0;
    }
    for one in held.nodes.iter() {
        let block = &mut flat[one.node as usize * size..][..size];
        let largest = block.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        one.project_block(block, components, RIGID * largest);
    }
    flat
}
