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

/// Adds M into the block of `matrix` that starts at `offset`.
pub fn add_mass(surface: &ContactSurface, offset: usize, matrix: &mut DenseMatrix) {
    for face in &surface.faces {
        let entry = |i, j| surface.basis.mass(face, i, j);
        add_local(face, offset, matrix, entry);
    }
}

/// Adds L into the block of `matrix` that starts at `offset`; `scale` multiplies
/// the coordinates.
pub fn add_laplacian(
    surface: &ContactSurface,
    mesh: &Mesh,
    scale: f64,
    offset: usize,
    matrix: &mut DenseMatrix,
) {
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
        add_local(face, offset, matrix, entry);
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

/// Adds the local matrix of one face to `matrix`; the multipliers of the surface begin
/// at row and column `offset`.
fn add_local(
    face: &ContactFace,
    offset: usize,
    matrix: &mut DenseMatrix,
    entry: impl Fn(usize, usize) -> f64,
) {
    let at = |multiplier: u32| offset + multiplier as usize;
    for (i, &row) in face.multipliers.iter().enumerate() {
        for (j, &column) in face.multipliers.iter().enumerate() {
            *matrix.at_mut(at(row), at(column)) += entry(i, j);
        }
    }
}
