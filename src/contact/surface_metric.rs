//! Dense mass and stiffness of the multiplier functions of one surface:
//!
//! ```text
//! M_ij = int psi_i psi_j dS,   L_ij = int grad psi_i . grad psi_j dS
//! ```
//!
//! `[multipliers, multipliers]`, undeformed, non-dimensional; gradients along the
//! surface. Cost: the entries.

use std::f64::consts::PI;

use super::face::ContactFace;
use super::surface::ContactSurface;
use crate::assembly::load::position;
use crate::linalg::DenseMatrix;
use crate::mesh::Mesh;

/// Adds M to `matrix` `[multipliers, multipliers]`.
pub fn add_mass(surface: &ContactSurface, matrix: &mut DenseMatrix) {
    for face in &surface.faces {
        let entry = |i, j| surface.basis.mass(face, i, j);
        add_local((surface, face), matrix, entry);
    }
}

/// Adds L to `matrix` `[multipliers, multipliers]`; `scale` multiplies the coordinates.
pub fn add_laplacian(surface: &ContactSurface, mesh: &Mesh, scale: f64, matrix: &mut DenseMatrix) {
    for face in &surface.faces {
        let opposite = opposite_edges(face, mesh, scale);
        // A segment's hats have slopes of 1 / length, a triangle's of
        // edge / (2 area).
        let denominator = match (face.corners.len(), face.radii) {
            (2, None) => face.area,
            // Its length over the way around.
            (2, Some([a, b])) => face.area / (PI * (a + b)).powi(2),
            _ => 4.0 * face.area,
        };
        let hats = |a: usize, b: usize| {
            let product: f64 = (0..3).map(|k| opposite[a][k] * opposite[b][k]).sum();
            product / denominator
        };
        let corners = face.corners.len();
        let entry = |i, j| surface.basis.laplacian(corners, &hats, [i, j]);
        add_local((surface, face), matrix, entry);
    }
}

/// Of a triangle, the edges opposite to the corners; of a segment, unit vectors
/// out of the ends.
fn opposite_edges(face: &ContactFace, mesh: &Mesh, scale: f64) -> Vec<[f64; 3]> {
    let corner = |index: usize| {
        let mut hats = vec![0.0; face.corners.len()];
        hats[index] = 1.0;
        position(mesh, scale, &face.corners, &hats)
    };
    let between = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| b[k] - a[k]);
    match face.corners.len() {
        2 => vec![[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]],
        count => (0..count)
            .map(|i| between(corner((i + 1) % count), corner((i + 2) % count)))
            .collect(),
    }
}

/// Adds the local matrix of one face to `matrix`.
fn add_local(
    (surface, face): (&ContactSurface, &ContactFace),
    matrix: &mut DenseMatrix,
    entry: impl Fn(usize, usize) -> f64,
) {
    for (i, &row) in face.functions.iter().enumerate() {
        for (j, &column) in face.functions.iter().enumerate() {
            for (row, left) in surface.shares.of(row) {
                for (column, right) in surface.shares.of(column) {
                    *matrix.at_mut(row as usize, column as usize) += left * right * entry(i, j);
                }
            }
        }
    }
}
