//! P1 mass matrices with a weight per cell: the pressure metric and the volume
//! compliance C = M / lambda.

use super::cells::CellGeometry;
use crate::linalg::SparseRows;
use crate::mesh::Mesh;

/// `M_ij = sum over cells of weight * int l_i l_j` `[vertices, vertices]`.
pub fn weighted_mass(
    mesh: &Mesh,
    geometry: &CellGeometry,
    weight: impl Fn(usize) -> f64,
) -> SparseRows {
    let vertices = geometry.vertices;
    let denominator = (vertices * (vertices + 1)) as f64;
    SparseRows::assemble(
        mesh.coordinates().len(),
        mesh.cells(),
        vertices,
        |cell, i, j| {
            let mean = if i == j { 2.0 } else { 1.0 } / denominator;
            weight(cell) * geometry.volumes[cell] * mean
        },
    )
}
