//! The P1 hats L_v of the vertices.
//!
//! One multiplier a vertex of the surface, for contact from one side: beside P2
//! displacements the pair is stable, and every function is positive, so that
//! `lambda >= 0` at the vertices is `lambda >= 0` everywhere.

use std::f64::consts::TAU;

use super::ContactBasis;
use crate::contact::face::ContactFace;

/// One function a vertex: its barycentric coordinate.
#[derive(Clone, Copy, Debug)]
pub struct Hats;

impl ContactBasis for Hats {
    fn functions(&self, corners: usize) -> usize {
        corners
    }

    fn values(&self, l: &[f64], out: &mut [f64]) {
        out.copy_from_slice(l);
    }

    fn at_nodes(&self, _corners: usize, coefficients: &[f64]) -> Vec<f64> {
        coefficients.to_vec()
    }

    fn largest(&self, corners: usize, coefficients: &[f64]) -> (f64, [f64; 3]) {
        let at_corner = |own: usize| std::array::from_fn(|i| if i == own { 1.0 } else { 0.0 });
        let values = coefficients.iter().take(corners).enumerate();
        values.fold((0.0, at_corner(0)), |known, (corner, &value)| {
            if value > known.0 {
                (value, at_corner(corner))
            } else {
                known
            }
        })
    }

    fn weight(&self, face: &ContactFace, k: usize) -> f64 {
        match face.radii {
            None => face.area / face.corners.len() as f64,
            Some([a, b]) => TAU * face.flat_area * [2.0 * a + b, a + 2.0 * b][k] / 6.0,
        }
    }

    fn mass(&self, face: &ContactFace, i: usize, j: usize) -> f64 {
        let corners = face.corners.len();
        let mean = face.area / (corners * (corners + 1)) as f64;
        if i == j { 2.0 * mean } else { mean }
    }

    fn laplacian(
        &self,
        _corners: usize,
        hats: &dyn Fn(usize, usize) -> f64,
        [i, j]: [usize; 2],
    ) -> f64 {
        hats(i, j)
    }
}
