//! The assembled edge block A22 of the P2 stiffness, for methods that sweep it.
//!
//! Edge functions 4 l_a l_b are the same in the hierarchical and the Lagrange
//! basis. On a straight cell edges (a, b) and (c, d) couple by
//! 16 V [m_ac K_bd + m_ad K_bc + m_bc K_ad + m_bd K_ac], where K_xy is the
//! coupling of barycentric gradients and m the mean of l_x l_y. About 54 blocks
//! per vertex of a solid: 180 bytes per displacement unknown.

use signorini::assembly::cells::{CellGeometry, CellModuli};
use signorini::assembly::p1_stiffness::{Block, add, coupling};
use signorini::mesh::Mesh;

/// A22 by edges and pairs of edges, held components not yet eliminated.
#[derive(Clone, Debug, Default)]
pub(crate) struct EdgeBlocks {
    /// Diagonal block of each edge `[edges]`: the stiffness between the components of
    /// its midpoint.
    pub(crate) diagonal: Vec<Block>,
    /// Lower and upper edge of each coupling, in lexicographic order.
    pub(crate) pairs: Vec<[u32; 2]>,
    /// Block of each coupling: rows of the lower edge, columns of the upper one.
    pub(crate) off: Vec<Block>,
}

/// A coupling of two edges in one cell, by local numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Coupled {
    /// Local numbers of the two edges in the list of pairs, lower one first.
    pair: [u32; 2],
    /// Cell in which the two edges meet, 0-based.
    cell: u32,
    /// Numbers of the two edges within that cell, 0 to 5 (in the plane: 0 to 2).
    local: [u8; 2],
}

/// A22 of `mesh`.
pub(crate) fn edge_blocks(mesh: &Mesh, geometry: &CellGeometry, moduli: &CellModuli) -> EdgeBlocks {
    let mut blocks = EdgeBlocks {
        diagonal: vec![[[0.0; 3]; 3]; mesh.edges().len()],
        ..EdgeBlocks::default()
    };
    let ends = mesh.cell_kind().edges();
    let block = |cell: usize, local: [u8; 2]| {
        let [first, second] = local.map(|edge| ends[usize::from(edge)]);
        edge_coupling(geometry, moduli, cell, [first, second])
    };
    for (cell, edges) in mesh.cell_edges().chunks_exact(ends.len()).enumerate() {
        for (local, &edge) in edges.iter().enumerate() {
            let own = block(cell, [local as u8; 2]);
            add(&mut blocks.diagonal[edge as usize], 1.0, &own);
        }
    }
    for one in couplings(mesh) {
        if blocks.pairs.last() != Some(&one.pair) {
            blocks.pairs.push(one.pair);
            blocks.off.push([[0.0; 3]; 3]);
        }
        if let Some(sum) = blocks.off.last_mut() {
            add(sum, 1.0, &block(one.cell as usize, one.local));
        }
    }
    blocks
}

/// Couplings of all cells, sorted by pair and then by cell.
fn couplings(mesh: &Mesh) -> Vec<Coupled> {
    let per_cell = mesh.cell_kind().edges().len();
    let mut list = Vec::with_capacity(mesh.cell_count() * per_cell * (per_cell - 1) / 2);
    for (cell, edges) in mesh.cell_edges().chunks_exact(per_cell).enumerate() {
        for first in 0..per_cell {
            for second in 0..first {
                let (low, high) = if edges[first] < edges[second] {
                    (first, second)
                } else {
                    (second, first)
                };
                list.push(Coupled {
                    pair: [edges[low], edges[high]],
                    cell: cell as u32,
                    local: [low as u8, high as u8],
                });
            }
        }
    }
    list.sort_unstable();
    list
}

/// The block of edges `first` (rows) and `second` (columns) in one cell.
fn edge_coupling(
    geometry: &CellGeometry,
    moduli: &CellModuli,
    cell: usize,
    [first, second]: [(usize, usize); 2],
) -> Block {
    let g = geometry.gradients_of(cell);
    let vertices = geometry.vertices as f64;
    let mean = |i: usize, j: usize| {
        let factor = if i == j { 2.0 } else { 1.0 };
        factor / (vertices * (vertices + 1.0))
    };
    let (shear, lame) = (moduli.shear[cell], moduli.lame[cell]);
    let mut block = [[0.0; 3]; 3];
    for (a, b) in [first, (first.1, first.0)] {
        for (c, d) in [second, (second.1, second.0)] {
            let part = coupling(shear, lame, &g[b], &g[d]);
            add(
                &mut block,
                16.0 * geometry.volumes[cell] * mean(a, c),
                &part,
            );
        }
    }
    block
}

#[cfg(test)]
mod tests;
