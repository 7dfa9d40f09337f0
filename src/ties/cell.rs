//! Where a point is in a cell, or beside it, and what the displacement is there:
//!
//! ```text
//! x = sum L_v X_v + sum 4 L_a L_b o_e,   u(x) = sum L_v u_v + sum 4 L_a L_b u_e
//! ```
//!
//! L the barycentric coordinates, negative beyond a facet; o_e offsets of curved edges. Lengths of
//! the mesh. Cost: some 50 flops, in a curved cell 200 a step of Newton's method.

use crate::element::curved_cell::CurvedCell;
use crate::geometry::vector3::{dot, norm, sub};
use crate::mesh::{Mesh, barycentric_gradients};
use crate::space::TaylorHood;

/// Steps of Newton's method in a curved cell: quadratic, from the straight one.
const STEPS: usize = 12;
/// Distance that is left of a point that is found, over that from a vertex of the cell and from the origin: above
/// rounding, and far below what one step leaves that does not converge.
const FOUND: f64 = 1e-10;

/// A node with the value of its function.
pub type Value = (u32, f64);

/// Barycentric coordinates of `x` in `cell`, those beyond its vertices zero; none where they are not
/// found.
pub fn coordinates(mesh: &Mesh, cell: usize, x: [f64; 3]) -> Option<[f64; 4]> {
    let kind = mesh.cell_kind();
    let corners = mesh.corners(cell);
    let gradients = barycentric_gradients(kind, &corners);
    let straight = |x: [f64; 3]| {
        let mut l = [0.0; 4];
        for (vertex, facet) in kind.facets().iter().enumerate() {
            l[vertex] = dot(gradients[vertex], sub(x, corners[facet[0]]));
        }
        l
    };
    let mut l = straight(x);
    if let Some(offsets) = mesh.offsets_of_cell(cell) {
        let vertices = kind.vertices();
        let curved = CurvedCell::new(&gradients[..vertices], kind.edges(), offsets);
        for _ in 0..STEPS {
            let missing = sub(x, mesh.position_in(cell, &l));
            let back = curved.map(&l[..vertices]).inverse;
            let step = back.map(|row| dot(row, missing));
            let shares = l.iter_mut().zip(gradients);
            shares.for_each(|(share, gradient)| *share += dot(gradient, step));
        }
    }
    let left = norm(sub(x, mesh.position_in(cell, &l)));
    let size = corners
        .iter()
        .map(|corner| norm(sub(x, *corner)))
        .fold(0.0, f64::max);
    (left <= FOUND * size).then_some(l)
}

/// Length by which the coordinate `share` of a vertex puts a point beyond the facet opposite to it.
pub fn beyond(mesh: &Mesh, (cell, vertex): (usize, usize), share: f64) -> f64 {
    let gradients = barycentric_gradients(mesh.cell_kind(), &mesh.corners(cell));
    (share / norm(gradients[vertex])).abs()
}

/// The functions of the displacement in `cell` at `l`.
pub fn values(mesh: &Mesh, space: &TaylorHood, (cell, l): (usize, [f64; 4])) -> Vec<Value> {
    let edges = mesh.cell_kind().edges();
    let own = &mesh.cell_edges()[cell * edges.len()..(cell + 1) * edges.len()];
    let corners = mesh.cell(cell).iter().copied().zip(l);
    let middles = own.iter().zip(edges).map(|(&edge, &(a, b))| {
        let node = space.vertices as u32 + edge;
        (node, 4.0 * l[a] * l[b])
    });
    corners.chain(middles).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::samples;

    #[test]
    fn a_point_beside_a_cell_has_the_values_of_a_quadratic_field() {
        let mesh = samples::cube(1);
        let space = TaylorHood::new(&mesh);
        let field = |[x, y, z]: [f64; 3]| 1.0 + 2.0 * x - y + x * y - 3.0 * z * z;
        let mut nodes: Vec<f64> = mesh.coordinates().iter().map(|&at| field(at)).collect();
        for &[a, b] in mesh.edges() {
            let [a, b] = [a, b].map(|v| mesh.coordinates()[v as usize]);
            let middle = [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]));
            nodes.push(field(middle) - 0.5 * (field(a) + field(b)));
        }
        let x = [0.3, -0.2, 1.1];
        let l = coordinates(&mesh, 2, x).expect("a point");
        let found = values(&mesh, &space, (2, l)).into_iter();
        let found: f64 = found
            .map(|(node, value)| value * nodes[node as usize])
            .sum();
        assert!((found - field(x)).abs() < 1e-13);
    }
}
