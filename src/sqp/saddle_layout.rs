//! What the saddle point of a body is assembled and ordered by: which displacement nodes
//! share a product when its entries are found ([`crate::assembly::probe`]), and the place
//! of each unknown in the elimination order. They depend on the mesh only.
//!
//! Cost: the square of the nodes near a node, for each, and a nested dissection.

use crate::assembly::probe::{Probed, Probes};
use crate::linalg::ordering::{Graph, nested_dissection};
use crate::linalg::{LinearOperator, SparseRows, Workspace};
use crate::model::Model;

/// Colours and places of a body's unknowns.
#[derive(Debug)]
pub(crate) struct SaddleLayout {
    /// Nodes in colours.
    pub(crate) probes: Probes,
    /// Place in the elimination order `[displacement]`; unknowns of a node share one.
    pub(crate) places: Vec<u32>,
}

impl SaddleLayout {
    /// Of the body of `model`.
    pub(crate) fn new(model: &Model<'_>) -> Self {
        Self {
            probes: Probes::new(model.mesh, &model.prepared.space),
            places: places(model),
        }
    }

    /// Stiffness and divergence as stored matrices, found by products; none where `stopped` says
    /// so on the way.
    pub(crate) fn stored(
        &self,
        (stiffness, divergence): (&dyn LinearOperator, Option<&dyn LinearOperator>),
        stopped: &dyn Fn() -> bool,
        work: &mut Workspace,
    ) -> Option<(SparseRows, Option<SparseRows>)> {
        let square = Probed {
            operator: stiffness,
            rows: self.probes.components,
        };
        let stiffness = self.probes.matrix(square, stopped, work)?;
        let divergence = match divergence {
            Some(operator) => {
                let probed = Probed { operator, rows: 1 };
                Some(self.probes.matrix(probed, stopped, work)?)
            }
            None => None,
        };
        Some((stiffness, divergence))
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        self.probes.bytes() + 4 * self.places.len() as u64
    }
}

/// Place of each displacement unknown in the elimination order: a nested dissection of the
/// vertices, each edge with the first of its ends. A separator of vertices with the edges
/// between them parts the cells, and so all nodes.
fn places(model: &Model<'_>) -> Vec<u32> {
    let space = &model.prepared.space;
    let graph = Graph::from_edges(space.vertices, &space.edges);
    let order = nested_dissection(model.mesh.coordinates(), &graph, &[]);
    let mut of_vertex = vec![0; order.len()];
    for (place, &vertex) in order.iter().enumerate() {
        of_vertex[vertex as usize] = place as u32;
    }
    let first_end = |&[a, b]: &[u32; 2]| of_vertex[a as usize].min(of_vertex[b as usize]);
    let nodes = of_vertex.iter().copied();
    nodes
        .chain(space.edges.iter().map(first_end))
        .flat_map(|place| std::iter::repeat_n(place, space.components))
        .collect()
}
