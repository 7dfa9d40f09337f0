//! The P2 stiffness on Lagrange nodes by blocks of node pairs: for smoothers
//! that solve along strongly coupled nodes.
//!
//! grad phi = (4 l_a - 1) g_a at vertex a, 4 (l_a g_b + l_b g_a) at edge ab: the
//! block of two nodes is a sum of the P1 blocks of gradient pairs, weighted by
//! means of products of affine functions. 55 blocks per tetrahedron; held
//! components are not yet eliminated.

use super::cells::{CellGeometry, CellModuli};
use super::p1_stiffness::{Block, add, coupling};
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Blocks of nodes and of pairs of nodes that share a cell.
#[derive(Clone, Debug)]
pub struct NodeCouplings {
    /// Lower and upper node of each pair, ascending.
    pub pairs: Vec<[u32; 2]>,
    /// Rows of the lower node, columns of the upper one `[pairs]`.
    pub off: Vec<Block>,
    /// Block of each node.
    pub diagonal: Vec<Block>,
}

/// One term of a shape function's gradient: `(constant + slope l_at) g_along`.
#[derive(Clone, Copy)]
struct Term {
    constant: f64,
    slope: f64,
    at: usize,
    along: usize,
}

/// Terms of every node of a cell: vertices, then edges.
fn terms(vertices: usize, edges: &[(usize, usize)]) -> Vec<Vec<Term>> {
    let term = |constant, slope, at, along| Term {
        constant,
        slope,
        at,
        along,
    };
    let corners = (0..vertices).map(|a| vec![term(-1.0, 4.0, a, a)]);
    let middles = edges
        .iter()
        .map(|&(a, b)| vec![term(0.0, 4.0, a, b), term(0.0, 4.0, b, a)]);
    corners.chain(middles).collect()
}

/// Mean over a cell of the product of two terms' factors.
fn mean(a: Term, b: Term, vertices: usize) -> f64 {
    let n = vertices as f64;
    let square = if a.at == b.at { 2.0 } else { 1.0 } / (n * (n + 1.0));
    a.constant * b.constant
        + (a.constant * b.slope + b.constant * a.slope) / n
        + a.slope * b.slope * square
}

impl NodeCouplings {
    /// Adds `shift` times the mass of each cell, weighted by its shear modulus and spread evenly over
    /// its nodes, for bodies whose supports leave rigid modes.
    pub fn add_mass(
        &mut self,
        shift: f64,
        (mesh, space): (&Mesh, &TaylorHood),
        geometry: &CellGeometry,
        moduli: &CellModuli,
    ) {
        for cell in 0..geometry.cells() {
            let nodes = nodes_of(mesh, space, cell);
            let share = shift * moduli.shear[cell] * geometry.volumes[cell] / nodes.len() as f64;
            for &node in nodes.iter() {
                let block = &mut self.diagonal[node as usize];
                block
                    .iter_mut()
                    .enumerate()
                    .for_each(|(i, row)| row[i] += share);
            }
        }
    }
}

/// Assembles all blocks.
pub fn node_couplings(
    mesh: &Mesh,
    space: &TaylorHood,
    geometry: &CellGeometry,
    moduli: &CellModuli,
) -> NodeCouplings {
    let vertices = geometry.vertices;
    let edges = mesh.cell_kind().edges();
    let terms = terms(vertices, edges);
    let mut pairs = Vec::new();
    for cell in 0..geometry.cells() {
        let nodes = nodes_of(mesh, space, cell);
        for (i, &a) in nodes.iter().enumerate() {
            pairs.extend(nodes[..i].iter().map(|&b| [a.min(b), a.max(b)]));
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    let mut blocks = NodeCouplings {
        off: vec![Block::default(); pairs.len()],
        diagonal: vec![Block::default(); space.nodes()],
        pairs,
    };
    for cell in 0..geometry.cells() {
        let nodes = nodes_of(mesh, space, cell);
        let g = geometry.gradients_of(cell);
        let (shear, lame) = (moduli.shear[cell], moduli.augmented[cell]);
        for (i, &row) in nodes.iter().enumerate() {
            for (j, &column) in nodes
                .iter()
                .enumerate()
                .filter(|(_, column)| **column >= row)
            {
                let target = match blocks.pairs.binary_search(&[row, column]) {
                    Ok(pair) => &mut blocks.off[pair],
                    Err(_) => &mut blocks.diagonal[row as usize],
                };
                for &a in &terms[i] {
                    for &b in &terms[j] {
                        let weight = geometry.volumes[cell] * mean(a, b, vertices);
                        add(
                            target,
                            weight,
                            &coupling(shear, lame, &g[a.along], &g[b.along]),
                        );
                    }
                }
            }
        }
    }
    blocks
}

/// Vertices, then edges of a cell.
fn nodes_of(mesh: &Mesh, space: &TaylorHood, cell: usize) -> Vec<u32> {
    let edges = mesh.cell_kind().edges().len();
    let corners = mesh.cell(cell).iter();
    let middles = mesh.cell_edges()[cell * edges..(cell + 1) * edges].iter();
    corners
        .copied()
        .chain(middles.map(|&edge| space.vertices as u32 + edge))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::p1_stiffness::StiffCells;
    use crate::linalg::Held;
    use crate::mesh::samples;

    fn couplings(mesh: &Mesh) -> (TaylorHood, NodeCouplings, Vec<f64>) {
        let space = TaylorHood::new(mesh);
        let geometry = CellGeometry::new(mesh, 1.0);
        let moduli = CellModuli {
            shear: (0..mesh.cell_count())
                .map(|cell| 1.0 + (cell % 3) as f64)
                .collect(),
            lame: vec![0.7; mesh.cell_count()],
            augmented: vec![0.7; mesh.cell_count()],
            inverse_lame: Vec::new(),
        };
        let blocks = node_couplings(mesh, &space, &geometry, &moduli);
        let cells = StiffCells {
            mesh,
            space: &space,
            geometry: &geometry,
            stiffness: &moduli,
        };
        let diagonal = cells.node_blocks(&Held::of_entries(mesh.cell_kind().dimension(), []));
        (space, blocks, diagonal)
    }

    #[test]
    fn diagonal_blocks_are_those_of_the_smoother() {
        for mesh in [samples::cube(2), samples::rectangle(3, 2)] {
            let (space, blocks, exact) = couplings(&mesh);
            let c = space.components;
            for (node, block) in blocks.diagonal.iter().enumerate() {
                for i in 0..c {
                    for j in 0..c {
                        let expected = exact[(node * c + i) * c + j];
                        assert!((block[i][j] - expected).abs() < 1e-12, "{node}");
                    }
                }
            }
        }
    }

    #[test]
    fn rigid_translations_cause_no_force() {
        for mesh in [samples::cube(2), samples::rectangle(3, 2)] {
            let (space, blocks, _) = couplings(&mesh);
            let mut sums = blocks.diagonal.clone();
            for (&[a, b], block) in blocks.pairs.iter().zip(&blocks.off) {
                for i in 0..3 {
                    for j in 0..3 {
                        sums[a as usize][i][j] += block[i][j];
                        sums[b as usize][i][j] += block[j][i];
                    }
                }
            }
            assert_eq!(sums.len(), space.nodes());
            assert!(sums.iter().flatten().flatten().all(|sum| sum.abs() < 1e-11));
        }
    }
}
