//! A cell in the caller's units and its Lagrange functions at a point:
//!
//! ```text
//! grad u = sum_a u_a (x) grad N_a,   about the axis (grad u)_33 = u_x / x
//! grad N = F0^-T grad_straight N,   F0 = I + sum o_e (x) grad_straight N_e
//! ```
//!
//! o_e the offsets of its edges.

use super::shapes;
use crate::geometry::tensor::Tensor;
use crate::geometry::vector3::{add, cross, dot, scale, sub};
use crate::mesh::barycentric_gradients;
use crate::model::Model;
use crate::scene::SceneKind;

/// Corner positions in the caller's units.
pub(crate) fn positions(model: &Model<'_>, vertices: &[u32]) -> Vec<[f64; 3]> {
    let factor = model.plan.problem.units.coordinate_scale * model.plan.problem.units.length;
    let corner = |&vertex: &u32| scale(factor, model.mesh.coordinates()[vertex as usize]);
    vertices.iter().map(corner).collect()
}

/// Area times normal, right of the order of the `corners`, and the ends of the edges
/// of a facet; in the plane its length takes the place of the area.
pub(crate) fn facet_area(corners: &[[f64; 3]]) -> ([f64; 3], &'static [(usize, usize)]) {
    let along = sub(corners[1], corners[0]);
    match corners.get(2) {
        None => ([along[1], -along[0], 0.0], &[(0, 1)]),
        Some(&third) => (
            scale(0.5, cross(along, sub(third, corners[0]))),
            &[(0, 1), (0, 2), (1, 2)],
        ),
    }
}

/// A cell in the caller's units.
pub(crate) struct Cell {
    /// The undeformed ones, zero beyond those that it has.
    pub(crate) corners: [[f64; 3]; 4],
    gradients: [[f64; 3]; 4],
    vertices: usize,
    /// Of its vertices, then of its edges.
    pub(crate) nodes: Vec<usize>,
    pairs: &'static [(usize, usize)],
    /// Offsets of its edges.
    offsets: [[f64; 3]; 6],
    /// What the section stands for.
    kind: SceneKind,
}

/// Shape functions and the displacement gradient at a point.
pub(crate) struct Point {
    /// grad u.
    pub(crate) gradient: Tensor<f64>,
    /// Of the shape functions `[nodes]`.
    values: Vec<f64>,
    /// Their gradients `[nodes, 3]`.
    slopes: Vec<[f64; 3]>,
    /// The undeformed point.
    pub(crate) place: [f64; 3],
    /// Its volume over that of the straight cell.
    pub(crate) measure: f64,
}

impl Cell {
    /// The cell of this number.
    pub(crate) fn new(model: &Model<'_>, cell: usize) -> Self {
        let units = &model.plan.problem.units;
        let kind = model.mesh.cell_kind();
        let scale = units.coordinate_scale * units.length;
        let corners = model.mesh.corners(cell).map(|x| x.map(|x| x * scale));
        let vertices = model.mesh.cell(cell);
        let pairs = kind.edges();
        let edges = &model.mesh.cell_edges()[cell * pairs.len()..(cell + 1) * pairs.len()];
        let first = model.prepared.space.vertices;
        let edge_nodes = edges.iter().map(|&e| first + e as usize);
        Self {
            corners,
            gradients: barycentric_gradients(kind, &corners),
            vertices: vertices.len(),
            nodes: vertices
                .iter()
                .map(|&v| v as usize)
                .chain(edge_nodes)
                .collect(),
            pairs,
            offsets: model
                .mesh
                .offsets_of_cell(cell)
                .unwrap_or_default()
                .map(|o| o.map(|x| x * scale)),
            kind: model.plan.problem.resolved.kind,
        }
    }

    /// Shape functions and gradient at barycentric coordinates `l`.
    pub(crate) fn point(&self, l: &[f64], nodal: &[[f64; 3]]) -> Point {
        let (values, mut slopes) = shapes(l, &self.gradients[..self.vertices], self.pairs);
        let bent = self.offsets.iter().zip(&slopes[self.vertices..]);
        let mut base = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (offset, slope) in bent {
            (0..3).for_each(|i| (0..3).for_each(|j| base[i][j] += offset[i] * slope[j]));
        }
        // Rows are J F0^-T.
        let across = [
            cross(base[1], base[2]),
            cross(base[2], base[0]),
            cross(base[0], base[1]),
        ];
        let measure = dot(base[0], across[0]);
        for slope in &mut slopes {
            *slope = across.map(|row| dot(row, *slope) / measure);
        }
        let mut gradient = [[0.0; 3]; 3];
        let mut along = 0.0;
        for (&node, (value, slope)) in self.nodes.iter().zip(values.iter().zip(&slopes)) {
            along += value * nodal[node][0];
            for i in 0..3 {
                for j in 0..3 {
                    gradient[i][j] += nodal[node][i] * slope[j];
                }
            }
        }
        let mut place = [0.0; 3];
        for (l, corner) in l.iter().zip(&self.corners) {
            place = add(place, scale(*l, *corner));
        }
        for (value, offset) in values[self.vertices..].iter().zip(&self.offsets) {
            place = add(place, scale(*value, *offset));
        }
        let radius = place[0];
        if self.kind == SceneKind::Axisymmetric {
            // On the axis the strains across it are equal.
            gradient[2][2] = if radius > 0.0 {
                along / radius
            } else {
                gradient[0][0]
            };
        }
        Point {
            gradient,
            values,
            slopes,
            place,
            measure,
        }
    }
}

impl Point {
    /// Takes `weight` P : grad v off `force`.
    pub(crate) fn take_off(
        &self,
        cell: &Cell,
        weight: f64,
        stress: &Tensor<f64>,
        force: &mut [[f64; 3]],
    ) {
        for (&node, slope) in cell.nodes.iter().zip(&self.slopes) {
            for i in 0..3 {
                for j in 0..3 {
                    force[node][i] -= weight * stress[i][j] * slope[j];
                }
            }
        }
        if cell.kind == SceneKind::Axisymmetric {
            let hoop = weight * stress[2][2] / self.place[0];
            let values = cell.nodes.iter().zip(&self.values);
            values.for_each(|(&node, value)| force[node][0] -= hoop * value);
        }
    }
}
