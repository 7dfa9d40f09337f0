//! A block of cells with its own numbering of the nodes it touches.

use super::{Basis, Rows};
use crate::assembly::cells::{CellGeometry, CellModuli};
use crate::assembly::kernel::{Batch, PRESSURE, edge_factor};
use crate::assembly::lanes::{Lanes, WIDTH};
use crate::assembly::simd::{self, InstructionSet};
use crate::assembly::strain::{Curve, PointPass, Terms};
use crate::assembly::transpose::Row;
use crate::linalg::{Held, HeldNode, Scalar};
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Nodes between asking for one and reading it.
const AHEAD: usize = 24;

/// Its nodes (vertices first), held entries, edge ends and batches.
#[derive(Clone, Debug)]
pub(in crate::assembly) struct Block<const V: usize, const D: usize, const E: usize> {
    pub(super) nodes: Vec<u32>,
    /// Local vertices precede local edges.
    vertices: usize,
    /// Local end vertices of each local edge.
    edge_ends: Vec<[u16; 2]>,
    /// Local node and component of held entries.
    held: Vec<(u16, u8)>,
    /// Directions of local nodes that are held.
    held_nodes: Vec<HeldNode>,
    pub(super) batches: Vec<Batch<V, D, E>>,
    /// Curved edges of the last batches.
    pub(super) curves: Vec<Curve<V, D, E>>,
    /// Radii of the vertices, batch by batch; empty where the body is not one of revolution.
    pub(super) radii: Vec<Lanes>,
}

/// What the blocks of a mesh are made from.
#[derive(Clone, Copy)]
pub struct GridSource<'a> {
    /// Mesh.
    pub mesh: &'a Mesh,
    /// Numbering.
    pub space: &'a TaylorHood,
    /// Gradients and volumes.
    pub geometry: &'a CellGeometry,
    /// Elasticity.
    pub moduli: &'a CellModuli,
    /// What is held.
    pub held: &'a Held,
}

impl<const V: usize, const D: usize, const E: usize> Block<V, D, E> {
    /// The block of `cells`; at most `u16::MAX` nodes.
    pub(super) fn new(cells: &[u32], source: GridSource<'_>) -> Self {
        let space = source.space;
        let cell_nodes: Vec<([u32; V], [u32; E])> = cells
            .iter()
            .map(|&cell| nodes_of_cell(source.mesh, space, cell as usize))
            .collect();
        let mut nodes: Vec<u32> = cell_nodes
            .iter()
            .flat_map(|(vertices, edges)| vertices.iter().chain(edges))
            .copied()
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        let local = |node: u32| nodes.partition_point(|&other| other < node) as u16;
        let vertices = nodes.partition_point(|&node| (node as usize) < space.vertices);
        let edge_ends = nodes[vertices..]
            .iter()
            .map(|&node| space.edges[node as usize - space.vertices].map(local))
            .collect();
        let batches = cells
            .chunks(WIDTH)
            .zip(cell_nodes.chunks(WIDTH))
            .map(|(cells, cell_nodes)| batch(cells, cell_nodes, source, &local))
            .collect();
        Self {
            held: held_of(&nodes, &source.held.entries, D as u32),
            held_nodes: held_nodes_of(&nodes, &source.held.nodes),
            vertices,
            edge_ends,
            curves: curves_of(cells, source.geometry),
            radii: radii_of::<V>(cells, source.geometry),
            batches,
            nodes,
        }
    }

    pub(super) fn bytes(&self) -> usize {
        size_of::<Batch<V, D, E>>() * self.batches.len()
            + size_of::<Curve<V, D, E>>() * self.curves.len()
            + size_of::<Lanes>() * self.radii.len()
            + 4 * (self.nodes.len() + self.edge_ends.len() + self.held.len())
    }

    /// The batches whose gradients are linear: none with curved edges, and none about an axis.
    pub(super) fn straight(&self) -> &[Batch<V, D, E>] {
        if self.radii.is_empty() {
            &self.batches[..self.batches.len() - self.curves.len()]
        } else {
            &[]
        }
    }

    /// The products of the other batches, point by point, added to `y`.
    pub(super) fn add_by_points(
        &self,
        (set, terms): (InstructionSet, Terms),
        x: &[Row],
        y: &mut [Row],
    ) {
        let pass = PointPass {
            batches: &self.batches[self.straight().len()..],
            curves: &self.curves,
            radii: &self.radii,
            x,
            y,
        };
        pass.run(set, terms);
    }

    /// Displacements of the block's nodes in its own rows.
    pub(in crate::assembly) fn gather_displacement<R: Scalar>(&self, x: &[R], rows: &mut [Row<R>]) {
        let (sources, _) = x.as_chunks::<D>();
        let ahead = self.nodes.iter().skip(AHEAD).chain(std::iter::repeat(&0));
        for ((row, &node), &later) in rows.iter_mut().zip(&self.nodes).zip(ahead) {
            simd::prefetch_at(sources, later as usize);
            let source = &sources[node as usize];
            *row = std::array::from_fn(|i| if i < D { source[i] } else { R::default() });
        }
    }

    /// Pressures of the block's vertices; the displacement is left alone.
    pub(in crate::assembly) fn gather_pressure(&self, p: &[f64], rows: &mut [Row]) {
        let vertices = &self.nodes[..self.vertices];
        for (row, &vertex) in rows.iter_mut().zip(vertices) {
            row[PRESSURE] = p[vertex as usize];
        }
    }

    fn mask<R: Scalar>(&self, rows: Rows, x: &mut [Row<R>]) {
        if rows == Rows::Free {
            for &(node, component) in &self.held {
                x[usize::from(node)][usize::from(component)] = R::default();
            }
            for one in &self.held_nodes {
                one.project(&mut x[one.node as usize][..D]);
            }
        }
    }

    pub(in crate::assembly) fn prepare_argument<R: Scalar>(
        &self,
        basis: Basis,
        rows: Rows,
        x: &mut [Row<R>],
    ) {
        self.mask(rows, x);
        let (factor, half) = (R::narrow(edge_factor(V)), R::narrow(0.5));
        let (vertices, edges) = x.split_at_mut(self.vertices);
        match basis {
            Basis::Hierarchical => edges
                .as_flattened_mut()
                .iter_mut()
                .for_each(|c| *c = *c * factor),
            Basis::Lagrange => {
                for (edge, ends) in edges.iter_mut().zip(&self.edge_ends) {
                    let [a, b] = ends.map(|end| vertices[usize::from(end)]);
                    let value = *edge;
                    *edge = std::array::from_fn(|i| factor * (value[i] - half * (a[i] + b[i])));
                }
            }
        }
    }

    pub(in crate::assembly) fn finish_result<R: Scalar>(
        &self,
        basis: Basis,
        rows: Rows,
        y: &mut [Row<R>],
    ) {
        let (factor, half) = (R::narrow(edge_factor(V)), R::narrow(0.5));
        let (vertices, edges) = y.split_at_mut(self.vertices);
        for edge in edges.iter_mut() {
            *edge = edge.map(|value| value * factor);
        }
        if basis == Basis::Lagrange {
            for (edge, ends) in edges.iter().zip(&self.edge_ends) {
                for end in ends {
                    let vertex = &mut vertices[usize::from(*end)];
                    let value = *vertex;
                    *vertex = std::array::from_fn(|i| value[i] - half * edge[i]);
                }
            }
        }
        self.mask(rows, y);
    }
}

/// Curved edges of the batches of `cells`, from the first that has any.
fn curves_of<const V: usize, const D: usize, const E: usize>(
    cells: &[u32],
    geometry: &CellGeometry,
) -> Vec<Curve<V, D, E>> {
    let of = |cell: &u32| geometry.curves.of(*cell as usize);
    let straight = cells.partition_point(|cell| of(cell).is_none()) / WIDTH;
    let batches = cells.chunks(WIDTH).skip(straight);
    let curve = |cells: &[u32]| Curve::new(std::array::from_fn(|lane| of(cells.get(lane)?)));
    if cells.last().is_some_and(|cell| of(cell).is_some()) {
        batches.map(curve).collect()
    } else {
        Vec::new()
    }
}

/// Radii of the vertices of `cells`, batch by batch; missing lanes repeat the last cell.
fn radii_of<const V: usize>(cells: &[u32], geometry: &CellGeometry) -> Vec<Lanes> {
    let (radii, _) = geometry.corner_radii.as_chunks::<V>();
    if radii.is_empty() {
        return Vec::new();
    }
    let of_batch = |cells: &[u32]| -> [Lanes; V] {
        let cell = |lane: usize| cells[lane.min(cells.len() - 1)] as usize;
        std::array::from_fn(|a| Lanes(std::array::from_fn(|lane| radii[cell(lane)][a])))
    };
    cells.chunks(WIDTH).flat_map(of_batch).collect()
}

/// Local node and component of the held entries of a block.
fn held_of(nodes: &[u32], held: &[u32], components: u32) -> Vec<(u16, u8)> {
    let mut out = Vec::new();
    for (local, &node) in nodes.iter().enumerate() {
        let first = held.partition_point(|&entry| entry < node * components);
        let entries = held[first..].iter();
        for &entry in entries.take_while(|&&entry| entry < (node + 1) * components) {
            out.push((local as u16, (entry - node * components) as u8));
        }
    }
    out
}

/// Directions that are held at the nodes of a block, by their local numbers.
fn held_nodes_of(nodes: &[u32], held: &[HeldNode]) -> Vec<HeldNode> {
    let local = |one: &HeldNode| nodes.binary_search(&one.node).ok();
    let found = held.iter().filter_map(|one| Some((local(one)?, one)));
    let renamed = found.map(|(local, one)| HeldNode {
        node: local as u32,
        ..*one
    });
    renamed.collect()
}

/// Node numbers of a cell: vertices and edges.
fn nodes_of_cell<const V: usize, const E: usize>(
    mesh: &Mesh,
    space: &TaylorHood,
    cell: usize,
) -> ([u32; V], [u32; E]) {
    let edges = &mesh.cell_edges()[cell * E..(cell + 1) * E];
    (
        std::array::from_fn(|a| mesh.cells()[cell * V + a]),
        std::array::from_fn(|e| edges[e] + space.vertices as u32),
    )
}

/// A batch of up to eight cells; missing lanes repeat the last cell with
/// weight zero.
fn batch<const V: usize, const D: usize, const E: usize>(
    cells: &[u32],
    cell_nodes: &[([u32; V], [u32; E])],
    source: GridSource<'_>,
    local: &impl Fn(u32) -> u16,
) -> Batch<V, D, E> {
    let mut out = Batch {
        vertices: [[0; WIDTH]; V],
        edges: [[0; WIDTH]; E],
        gradients: [[Lanes::zero(); D]; D],
        shear: Lanes::zero(),
        lame: Lanes::zero(),
        augmented: Lanes::zero(),
        weight: Lanes::zero(),
    };
    for lane in 0..WIDTH {
        let member = lane.min(cells.len() - 1);
        let cell = cells[member] as usize;
        let (vertices, edges) = &cell_nodes[member];
        for (slot, &vertex) in out.vertices.iter_mut().zip(vertices) {
            slot[lane] = local(vertex);
        }
        for (slot, &edge) in out.edges.iter_mut().zip(edges) {
            slot[lane] = local(edge);
        }
        for a in 0..D {
            for j in 0..D {
                out.gradients[a][j].0[lane] = source.geometry.gradients_of(cell)[a + 1][j];
            }
        }
        if lane < cells.len() {
            let weight = source.geometry.volumes[cell] / V as f64;
            out.weight.0[lane] = weight;
            out.shear.0[lane] = weight * source.moduli.shear[cell];
            out.lame.0[lane] = weight * source.moduli.lame[cell];
            out.augmented.0[lane] = weight * source.moduli.augmented[cell];
        }
    }
    out
}
