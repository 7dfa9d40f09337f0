//! Load vectors in the hierarchical basis: body forces and surface tractions
//! given as functions of position.
//!
//! Vertex functions are barycentric coordinates, edge functions 4 l_a l_b.

use crate::element::quadrature::Rule;
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Node numbers and P2 hierarchical shape values of a simplex at a point with
/// barycentric coordinates `l`; edges in the order (0,1), (0,2), ..
pub fn shape_values(l: &[f64]) -> Vec<f64> {
    let mut values = l.to_vec();
    for (i, a) in l.iter().enumerate() {
        for b in &l[i + 1..] {
            values.push(4.0 * a * b);
        }
    }
    values
}

/// The point with barycentric coordinates `l` in the simplex of `vertices`.
pub fn position(mesh: &Mesh, scale: f64, vertices: &[u32], l: &[f64]) -> [f64; 3] {
    let mut point = [0.0; 3];
    for (&vertex, factor) in vertices.iter().zip(l) {
        let corner = mesh.coordinates()[vertex as usize];
        for i in 0..3 {
            point[i] += factor * scale * corner[i];
        }
    }
    point
}

fn integrate(
    space: &TaylorHood,
    nodes: &[u32],
    rule: &Rule,
    corners: usize,
    measure: f64,
    value: &dyn Fn(&[f64]) -> [f64; 3],
    load: &mut [f64],
) {
    for (point, weight) in rule.points.iter().zip(&rule.weights) {
        let l = &point[..corners];
        let density = value(l);
        for (&node, shape) in nodes.iter().zip(shape_values(l)) {
            for i in 0..space.components {
                load[node as usize * space.components + i] += measure * weight * shape * density[i];
            }
        }
    }
}

/// Adds `int f . v` over all cells; `f` takes a position.
pub fn add_body_force(
    mesh: &Mesh,
    space: &TaylorHood,
    volumes: &[f64],
    scale: f64,
    rule: &Rule,
    force: &dyn Fn(usize, [f64; 3]) -> [f64; 3],
    load: &mut [f64],
) {
    let vertices = mesh.cell_kind().vertices();
    let edges = mesh.cell_kind().edges().len();
    for (cell, corners) in mesh.cells().chunks_exact(vertices).enumerate() {
        let mut nodes = corners.to_vec();
        nodes.extend(
            mesh.cell_edges()[cell * edges..(cell + 1) * edges]
                .iter()
                .map(|&edge| edge + space.vertices as u32),
        );
        let value = |l: &[f64]| force(cell, position(mesh, scale, corners, l));
        integrate(space, &nodes, rule, vertices, volumes[cell], &value, load);
    }
}

/// Adds `int t . v` over one facet; `traction` takes a position.
#[allow(clippy::too_many_arguments)]
pub fn add_traction(
    mesh: &Mesh,
    space: &TaylorHood,
    facet: &[u32],
    area: f64,
    scale: f64,
    rule: &Rule,
    traction: &dyn Fn([f64; 3]) -> [f64; 3],
    load: &mut [f64],
) {
    let nodes = space.facet_nodes(facet);
    let value = |l: &[f64]| traction(position(mesh, scale, facet, l));
    integrate(space, &nodes, rule, facet.len(), area, &value, load);
}

/// Measure (area, or length in 2D) and unit normal of a facet. The normal
/// follows the order of the vertices; in 2D it points right of the segment.
pub fn facet_measure(mesh: &Mesh, facet: &[u32], scale: f64) -> (f64, [f64; 3]) {
    let point = |i: usize| mesh.coordinates()[facet[i] as usize].map(|x| x * scale);
    let edge = |a: [f64; 3], b: [f64; 3]| [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let along = edge(point(0), point(1));
    let (area_vector, measure_factor) = match facet.len() {
        2 => ([along[1], -along[0], 0.0], 1.0),
        _ => {
            let other = edge(point(0), point(2));
            let cross = [
                along[1] * other[2] - along[2] * other[1],
                along[2] * other[0] - along[0] * other[2],
                along[0] * other[1] - along[1] * other[0],
            ];
            (cross, 0.5)
        }
    };
    let length = area_vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    (measure_factor * length, area_vector.map(|x| x / length))
}
