//! Numbering of the hierarchical Taylor-Hood space of one mesh: displacement
//! P2 = P1 on vertices + corrections on edges, pressure P1 on vertices.
//!
//! Node n < vertices is a vertex, node vertices + e is edge e. The unknown of
//! component i at node n is `n * components + i`, so that the P1 displacement
//! is a prefix of the P2 displacement. The correction on an edge is the value
//! at its midpoint minus the mean of its ends.

use std::sync::Arc;

use crate::mesh::Mesh;

/// Sizes and edge ends of a space.
#[derive(Clone, Debug)]
pub struct TaylorHood {
    /// Components of the displacement: 2 or 3.
    pub components: usize,
    /// Vertices of the mesh.
    pub vertices: usize,
    /// End vertices of each edge, lexicographic.
    pub edges: Arc<[[u32; 2]]>,
}

impl TaylorHood {
    /// The space of `mesh`.
    pub fn new(mesh: &Mesh) -> Self {
        Self {
            components: mesh.cell_kind().dimension(),
            vertices: mesh.coordinates().len(),
            edges: mesh.edges().into(),
        }
    }

    /// Vertices plus edges.
    pub fn nodes(&self) -> usize {
        self.vertices + self.edges.len()
    }

    /// Displacement unknowns, held ones included.
    pub fn displacement_unknowns(&self) -> usize {
        self.nodes() * self.components
    }

    /// The edge between two vertices.
    pub fn edge_between(&self, a: u32, b: u32) -> Option<usize> {
        self.edges.binary_search(&[a.min(b), a.max(b)]).ok()
    }

    /// Nodes of a facet: its vertices, then its edges as node numbers, edge
    /// order (0,1), (0,2), (1,2).
    pub fn facet_nodes(&self, facet: &[u32]) -> Vec<u32> {
        let mut nodes = facet.to_vec();
        for (i, &a) in facet.iter().enumerate() {
            for &b in &facet[i + 1..] {
                if let Some(edge) = self.edge_between(a, b) {
                    nodes.push((self.vertices + edge) as u32);
                }
            }
        }
        nodes
    }

    /// Vertex and midpoint values of a hierarchical vector, [nodes * components].
    pub fn node_values(&self, hierarchical: &[f64]) -> Vec<f64> {
        let c = self.components;
        let mut values = hierarchical.to_vec();
        for (edge, ends) in self.edges.iter().enumerate() {
            for i in 0..c {
                let mean = 0.5
                    * (hierarchical[ends[0] as usize * c + i]
                        + hierarchical[ends[1] as usize * c + i]);
                values[(self.vertices + edge) * c + i] += mean;
            }
        }
        values
    }

    /// Forces on Lagrange nodes from hierarchical forces: each edge gives half
    /// of its force back to either end.
    pub fn node_forces(&self, hierarchical: &[f64]) -> Vec<f64> {
        let c = self.components;
        let mut forces = hierarchical.to_vec();
        for (edge, ends) in self.edges.iter().enumerate() {
            for i in 0..c {
                let half = 0.5 * hierarchical[(self.vertices + edge) * c + i];
                forces[ends[0] as usize * c + i] -= half;
                forces[ends[1] as usize * c + i] -= half;
            }
        }
        forces
    }
}
