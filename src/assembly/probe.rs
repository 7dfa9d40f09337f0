//! The entries of operators that are applied and never stored, found by products:
//!
//! ```text
//! y = M (sum of unit vectors e_j of one colour),   m_ij = y_i for the only j of the colour near i
//! ```
//!
//! Two nodes share a colour where no node shares a cell with both, so that every row meets
//! at most one of them (A. Curtis, M. Powell and J. Reid, IMA J. Appl. Math. 13, 1974). It
//! serves whatever couples no further than cells reach: stiffness and divergence at rest
//! or at any state, whichever kernel applies them. Cost: a product for each colour and
//! component, some 400 on tetrahedra and 80 on triangles, and 12 bytes an entry.

use crate::linalg::ordering::Graph;
use crate::linalg::{LinearOperator, SparseRows, SparseRowsBuilder, Workspace};
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// A colour that no node has yet.
const NONE: u32 = u32::MAX;

/// Nodes of a mesh in colours.
#[derive(Clone, Debug)]
pub struct Probes {
    /// The nodes that share a cell with each, itself included `[nodes]`.
    pub near: Graph,
    /// The nodes of each colour, ascending.
    colours: Vec<Vec<u32>>,
    /// Unknowns of a node.
    pub components: usize,
}

/// An operator from displacements.
#[derive(Clone, Copy)]
pub struct Probed<'a> {
    /// Its columns are displacement unknowns; its rows belong to the first nodes.
    pub operator: &'a dyn LinearOperator,
    /// Rows of a node.
    pub rows: usize,
}

impl Probes {
    /// Of the P2 nodes of `mesh`. Cost: the square of the nodes near a node, for each.
    pub fn new(mesh: &Mesh, space: &TaylorHood) -> Self {
        let near = near(mesh, space);
        Self {
            colours: colours(&near),
            near,
            components: space.components,
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        let near = 8 * self.near.offsets.len() + 4 * self.near.neighbours.len();
        (near + 4 * self.near.offsets.len()) as u64
    }

    /// The matrix of an operator that couples no further than cells; none where `stopped`
    /// says so between two products.
    pub fn matrix(
        &self,
        probed: Probed<'_>,
        stopped: &dyn Fn() -> bool,
        work: &mut Workspace,
    ) -> Option<SparseRows> {
        let (operator, c) = (probed.operator, self.components);
        let mut entries = vec![0.0; self.entries(probed)];
        let mut x = work.zeros(operator.columns());
        let mut y = work.scratch(operator.rows());
        for colour in &self.colours {
            if stopped() {
                return None;
            }
            for component in 0..c {
                let unknown = |node: u32| node as usize * c + component;
                colour.iter().for_each(|&node| x[unknown(node)] = 1.0);
                operator.apply(&x, &mut y, work);
                colour.iter().for_each(|&node| x[unknown(node)] = 0.0);
                for &node in colour {
                    self.take((node, component), probed.rows, &y, &mut entries);
                }
            }
        }
        work.give(x);
        work.give(y);
        Some(self.collect(probed, &entries))
    }

    /// Number of entries of the operator's matrix.
    fn entries(&self, probed: Probed<'_>) -> usize {
        let nodes = probed.operator.rows() / probed.rows;
        self.near.offsets[nodes] * probed.rows * self.components
    }

    /// Takes the column of a node's component from the product `y`.
    fn take(&self, (node, component): (u32, usize), rows: usize, y: &[f64], entries: &mut [f64]) {
        let nodes = y.len() / rows;
        for &row in self.near.neighbours(node) {
            let row = row as usize;
            if row >= nodes {
                break;
            }
            let near = self.near.neighbours(row as u32);
            let Ok(place) = near.binary_search(&node) else {
                continue;
            };
            let width = near.len() * self.components;
            let first = self.near.offsets[row] * rows * self.components;
            for i in 0..rows {
                let entry = first + i * width + place * self.components + component;
                entries[entry] = y[row * rows + i];
            }
        }
    }

    /// The rows of the matrix with those entries.
    fn collect(&self, probed: Probed<'_>, entries: &[f64]) -> SparseRows {
        let c = self.components;
        let mut builder = SparseRowsBuilder::new(probed.operator.columns());
        let mut row = Vec::new();
        let mut first = 0;
        for node in 0..probed.operator.rows() / probed.rows {
            let near = self.near.neighbours(node as u32);
            for _ in 0..probed.rows {
                row.clear();
                let columns = near
                    .iter()
                    .flat_map(|&n| (0..c).map(move |i| n * c as u32 + i as u32));
                row.extend(columns.zip(entries[first..].iter().copied()));
                first += near.len() * c;
                builder.push_row(&mut row);
            }
        }
        builder.finish()
    }
}

/// The nodes that share a cell with each, itself included.
fn near(mesh: &Mesh, space: &TaylorHood) -> Graph {
    let per_cell = mesh.cell_kind().edges().len();
    let mut near = vec![Vec::new(); space.nodes()];
    for (cell, edges) in mesh.cell_edges().chunks_exact(per_cell).enumerate() {
        let edges = edges.iter().map(|&edge| space.vertices as u32 + edge);
        let nodes: Vec<u32> = mesh.cell(cell).iter().copied().chain(edges).collect();
        for &node in &nodes {
            near[node as usize].extend_from_slice(&nodes);
        }
    }
    let mut graph = Graph {
        offsets: vec![0],
        neighbours: Vec::new(),
    };
    for mut list in near {
        list.sort_unstable();
        list.dedup();
        graph.neighbours.append(&mut list);
        graph.offsets.push(graph.neighbours.len());
    }
    graph
}

/// The nodes by colour: each node takes the first that no node two cells away has.
fn colours(near: &Graph) -> Vec<Vec<u32>> {
    let nodes = near.offsets.len() - 1;
    let mut of_node = vec![NONE; nodes];
    let mut colours: Vec<Vec<u32>> = Vec::new();
    // The last node that met each colour.
    let mut met: Vec<u32> = Vec::new();
    for node in 0..nodes as u32 {
        for &row in near.neighbours(node) {
            for &other in near.neighbours(row) {
                if let Some(met) = met.get_mut(of_node[other as usize] as usize) {
                    *met = node;
                }
            }
        }
        let free = met.iter().position(|&last| last != node);
        let colour = free.unwrap_or(met.len());
        if colour == met.len() {
            met.push(NONE);
            colours.push(Vec::new());
        }
        met[colour] = node;
        of_node[node as usize] = colour as u32;
        colours[colour].push(node);
    }
    colours
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::vector::reproducible_noise;
    use crate::mesh::samples;

    /// Springs between all components of nodes that share a cell.
    fn springs(probes: &Probes, rows: (usize, usize), columns: usize) -> SparseRows {
        let (nodes, per_node) = rows;
        let noise = reproducible_noise(nodes * per_node * columns);
        let mut builder = SparseRowsBuilder::new(columns);
        let c = probes.components;
        for row in 0..nodes * per_node {
            let near = probes.near.neighbours((row / per_node) as u32);
            let unknowns = near
                .iter()
                .flat_map(|&n| (0..c).map(move |i| n as usize * c + i));
            let entries = unknowns.map(|column| (column as u32, noise[row * columns + column]));
            builder.push_row(&mut entries.collect::<Vec<_>>());
        }
        builder.finish()
    }

    #[test]
    fn every_entry_is_found_of_square_and_of_rectangular_operators() {
        for mesh in [samples::cube(2), samples::rectangle(3, 2)] {
            let space = TaylorHood::new(&mesh);
            let probes = Probes::new(&mesh, &space);
            let columns = space.displacement_unknowns();
            for (nodes, rows) in [(space.nodes(), space.components), (space.vertices, 1)] {
                let matrix = springs(&probes, (nodes, rows), columns);
                let probed = Probed {
                    operator: &matrix,
                    rows,
                };
                let found = probes.matrix(probed, &|| false, &mut Workspace::new());
                assert_eq!(found.as_ref(), Some(&matrix));
            }
        }
    }

    #[test]
    fn few_products_are_needed_and_none_once_somebody_stops() {
        let mesh = samples::cube(6);
        let space = TaylorHood::new(&mesh);
        let probes = Probes::new(&mesh, &space);
        assert!(probes.colours.len() < 200, "{}", probes.colours.len());
        let matrix = SparseRowsBuilder::new(space.displacement_unknowns()).finish();
        let probed = Probed {
            operator: &matrix,
            rows: 1,
        };
        assert_eq!(probes.matrix(probed, &|| true, &mut Workspace::new()), None);
    }
}
