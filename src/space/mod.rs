//! Numbering of the hierarchical Taylor-Hood space of one mesh: displacement
//! P2 = P1 on vertices + corrections on edges, pressure P1 on vertices.
//!
//! Node n < vertices is a vertex, node vertices + e is edge e. The unknown of
//! component i at node n is `n * components + i`, so that the P1 displacement
//! is a prefix of the P2 displacement. The correction on an edge is the value
//! at its midpoint minus the mean of its ends.

mod values;

use std::sync::Arc;

use crate::mesh::Mesh;

/// Sizes and edge ends of a space.
#[derive(Clone, Debug)]
pub struct TaylorHood {
    /// Components of the displacement: 3 in space, 2 in the plane.
    pub components: usize,
    /// Number of mesh vertices, whose unknowns come first.
    pub vertices: usize,
    /// End vertices of each edge, ascending and in lexicographic order `[edges]`.
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

    /// Undeformed place of a node of `mesh`: of an edge its middle.
    pub fn node_place(&self, mesh: &Mesh, node: u32) -> [f64; 3] {
        let at = |vertex: u32| mesh.coordinates()[vertex as usize];
        match (node as usize).checked_sub(self.vertices) {
            None => at(node),
            Some(edge) => {
                let [a, b] = self.edges[edge].map(at);
                let offset = mesh.offset_of(edge);
                [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]) + offset[i])
            }
        }
    }

    /// Vertex and midpoint values of a hierarchical vector, `[nodes * components]`.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::vector::{dot, reproducible_noise};
    use crate::mesh::samples;

    #[test]
    fn vertices_come_first_and_edges_follow_in_lexicographic_order() {
        let mesh = samples::cube(2);
        let space = TaylorHood::new(&mesh);
        assert_eq!((space.components, space.vertices), (3, 27));
        assert!(space.edges.is_sorted() && space.edges.iter().all(|[a, b]| a < b));
        assert_eq!(space.displacement_unknowns(), 3 * (27 + space.edges.len()));
        for (edge, &[a, b]) in space.edges.iter().enumerate() {
            assert_eq!(space.edge_between(b, a), Some(edge));
        }
        assert_eq!(space.edge_between(0, 0), None);
    }

    #[test]
    fn a_facet_has_its_vertices_then_its_edges() {
        let mesh = samples::cube(1);
        let space = TaylorHood::new(&mesh);
        let facet = mesh.facet(0);
        let nodes = space.facet_nodes(facet);
        assert_eq!(&nodes[..3], facet);
        for (node, (i, j)) in nodes[3..].iter().zip([(0, 1), (0, 2), (1, 2)]) {
            let edge = space.edge_between(facet[i], facet[j]).expect("an edge");
            assert_eq!(*node as usize, space.vertices + edge);
        }
        assert_eq!(nodes.len(), 6);
    }

    #[test]
    fn node_forces_do_on_node_values_the_work_of_the_hierarchical_ones() {
        for mesh in [samples::cube(2), samples::rectangle(2, 3)] {
            let space = TaylorHood::new(&mesh);
            let values = reproducible_noise(space.displacement_unknowns());
            let forces: Vec<f64> = values.iter().rev().copied().collect();
            let work = dot(&space.node_forces(&forces), &space.node_values(&values));
            assert!((work - dot(&forces, &values)).abs() < 1e-12);
        }
    }
}
