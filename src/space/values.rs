//! Values of a hierarchical P2 field at points of cells:
//!
//! ```text
//! u = sum l_a u_a + sum 4 l_a l_b c_ab,   grad u = sum u_a grad l_a + sum c_ab 4 (l_a grad l_b + l_b grad l_a)
//! ```
//!
//! u_a at vertices, c_ab the corrections at edges. Points are barycentric coordinates
//! `[4]`. Cost: some 100 flops.

use super::TaylorHood;
use crate::geometry::Matrix3;
use crate::mesh::Mesh;

impl TaylorHood {
    /// The field `[nodes * components]` at a point of a cell `[3]`, components that the
    /// field lacks being zero.
    pub fn value_at(
        &self,
        mesh: &Mesh,
        field: &[f64],
        cell: usize,
        barycentric: &[f64; 4],
    ) -> [f64; 3] {
        let c = self.components;
        let mut value = [0.0; 3];
        let mut add = |node: usize, shape: f64| {
            for i in 0..c {
                value[i] += shape * field[node * c + i];
            }
        };
        for (&vertex, &l) in mesh.cell(cell).iter().zip(barycentric) {
            add(vertex as usize, l);
        }
        for (node, (a, b)) in self.edge_nodes_of(mesh, cell) {
            add(node, 4.0 * barycentric[a] * barycentric[b]);
        }
        value
    }

    /// Gradient du_i/dx_j `[3, 3]` of the field at a point of a cell, whose hats have the
    /// gradients `hats` `[corners, 3]`.
    pub fn gradient_at(
        &self,
        mesh: &Mesh,
        field: &[f64],
        (cell, hats): (usize, &[[f64; 3]]),
        barycentric: &[f64; 4],
    ) -> Matrix3 {
        let c = self.components;
        let mut gradient = [[0.0; 3]; 3];
        let mut add = |node: usize, slope: [f64; 3]| {
            for i in 0..c {
                for j in 0..3 {
                    gradient[i][j] += field[node * c + i] * slope[j];
                }
            }
        };
        for (&vertex, slope) in mesh.cell(cell).iter().zip(hats) {
            add(vertex as usize, *slope);
        }
        for (node, (a, b)) in self.edge_nodes_of(mesh, cell) {
            let slope = std::array::from_fn(|j| {
                4.0 * (barycentric[a] * hats[b][j] + barycentric[b] * hats[a][j])
            });
            add(node, slope);
        }
        gradient
    }

    /// Edge nodes of a cell, each with the two corners that it lies between.
    pub(crate) fn edge_nodes_of<'a>(
        &self,
        mesh: &'a Mesh,
        cell: usize,
    ) -> impl Iterator<Item = (usize, (usize, usize))> + 'a {
        let pairs = mesh.cell_kind().edges();
        let edges = &mesh.cell_edges()[cell * pairs.len()..(cell + 1) * pairs.len()];
        let vertices = self.vertices;
        let nodes = edges.iter().map(move |&edge| vertices + edge as usize);
        nodes.zip(pairs.iter().copied())
    }
}
