//! P1 mass matrices with a weight per cell: the pressure metric and the volume
//! compliance C = M / lambda.

use super::cells::CellGeometry;
use crate::element::quadrature::Rule;
use crate::linalg::SparseRows;
use crate::mesh::Mesh;

/// Mean of l_i l_j over a triangle, at point weights x over their mean.
fn ring_mean(x: [f64; 3], i: usize, j: usize) -> f64 {
    let moment = |k: usize| match (i == j, k == i || k == j) {
        (true, true) => 1.0 / 10.0,
        (true, false) | (false, true) => 1.0 / 30.0,
        (false, false) => 1.0 / 60.0,
    };
    let sum: f64 = (0..3).map(|k| x[k] * moment(k)).sum();
    3.0 * sum / (x[0] + x[1] + x[2])
}

/// Mean of l_i l_j over a curved cell, over the measure of the straight one.
fn curved_mean(
    (mesh, geometry, rule): (&Mesh, &CellGeometry, &Rule),
    cell: usize,
    [i, j]: [usize; 2],
) -> f64 {
    let corners = mesh.corners(cell).into_iter().take(geometry.vertices);
    let sum: f64 = corners.map(|x| x[0]).sum();
    let points = rule.points.iter().zip(&rule.weights);
    let terms = points.map(|(l, weight)| {
        let turn = if geometry.radii.is_empty() {
            1.0
        } else {
            mesh.position_in(cell, l)[0] * geometry.vertices as f64 / sum
        };
        weight * turn * geometry.curves.measure(cell, l) * l[i] * l[j]
    });
    terms.sum()
}

/// `M_ij = sum over cells of weight * int l_i l_j` `[vertices, vertices]`, on cells with curved edges
/// by the `rule` of their volumes.
pub fn weighted_mass(
    (mesh, geometry): (&Mesh, &CellGeometry),
    rule: &Rule,
    weight: impl Fn(usize) -> f64,
) -> SparseRows {
    let vertices = geometry.vertices;
    let denominator = (vertices * (vertices + 1)) as f64;
    SparseRows::assemble(
        mesh.coordinates().len(),
        mesh.cells(),
        vertices,
        |cell, i, j| {
            let mean = match geometry.radii.is_empty() {
                _ if geometry.curves.of(cell).is_some() => {
                    curved_mean((mesh, geometry, rule), cell, [i, j])
                }
                true if i == j => 2.0 / denominator,
                true => 1.0 / denominator,
                false => ring_mean([0, 1, 2].map(|k| mesh.corners(cell)[k][0]), i, j),
            };
            weight(cell) * geometry.volumes[cell] * mean
        },
    )
}
