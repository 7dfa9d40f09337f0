//! Metrics of multiplier blocks: approximate inverses of Schur complements.
//!
//! Pressure: B A^-1 B^T + C is close to the pressure mass weighted by
//! 1/(2 mu) + 1/lambda; a few Chebyshev steps around its diagonal invert it.
//! The spectrum of diag(M)^-1 M for P1 lies in [1/2, (d+2)/2] on every mesh
//! (A. Wathen, IMA J. Numer. Anal. 7, 1987), so no estimate is needed. The
//! lumped mass instead doubles the iterations of the saddle point in 3D.

use super::chebyshev::{Chebyshev, Step};
use crate::linalg::vector::{add_scaled, subtract_from};
use crate::linalg::{LinearOperator, Preconditioner, SparseRows, Workspace};

/// Inverse of a P1 mass matrix by a fixed Chebyshev polynomial.
#[derive(Clone, Debug)]
pub struct ChebyshevMass {
    /// The P1 mass matrix `[vertices, vertices]`, weighted by cells.
    mass: SparseRows,
    /// Reciprocal diagonal of the mass `[vertices]`.
    inverse_diagonal: Vec<f64>,
    /// Upper end of the interval that holds the spectrum of the scaled mass.
    largest: f64,
    /// Number of Chebyshev steps, each one product with the mass.
    steps: usize,
}

impl ChebyshevMass {
    /// `dimension` 2 or 3 of the mesh; error of `steps` steps about
    /// 2 * 0.38^steps in 3D.
    pub fn new(mass: SparseRows, dimension: usize, steps: usize) -> Self {
        let inverse_diagonal = mass.diagonal().iter().map(|d| 1.0 / d).collect();
        Self {
            mass,
            inverse_diagonal,
            largest: (dimension as f64 + 2.0) / 2.0,
            steps,
        }
    }

    /// The mass matrix.
    pub fn mass(&self) -> &SparseRows {
        &self.mass
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        self.mass.bytes() + 8 * self.inverse_diagonal.len() as u64
    }

    /// One Chebyshev step of the direction: d = keep d + gain D^-1 r.
    fn update(&self, Step { keep, gain }: Step, r: &[f64], d: &mut [f64]) {
        for ((d, r), inverse) in d.iter_mut().zip(r).zip(&self.inverse_diagonal) {
            *d = keep * *d + gain * inverse * r;
        }
    }
}

impl Preconditioner for ChebyshevMass {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let mut chebyshev = Chebyshev::new(0.5, self.largest);
        let mut direction = work.zeros(r.len());
        let mut product = work.scratch(r.len());
        self.update(chebyshev.advance(), r, &mut direction);
        z.copy_from_slice(&direction);
        for _ in 1..self.steps {
            self.mass.apply(z, &mut product, work);
            subtract_from(&mut product, r);
            self.update(chebyshev.advance(), &product, &mut direction);
            add_scaled(z, 1.0, &direction);
        }
        work.give(direction);
        work.give(product);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_steps_invert_the_mass_of_a_chain_of_triangles() {
        let cells: Vec<u32> = (0..50).flat_map(|i| [i, i + 1, i + 2]).collect();
        let mass = SparseRows::assemble(52, &cells, 3, |_, i, j| if i == j { 2.0 } else { 1.0 });
        let metric = ChebyshevMass::new(mass.clone(), 2, 8);
        let mut work = Workspace::new();
        let exact = crate::linalg::vector::reproducible_noise(52);
        let mut r = vec![0.0; 52];
        mass.apply(&exact, &mut r, &mut work);
        let mut z = vec![0.0; 52];
        metric.apply(&r, &mut z, &mut work);
        subtract_from(&mut z, &exact);
        let error = crate::linalg::vector::norm(&z) / crate::linalg::vector::norm(&exact);
        assert!(error < 5e-3, "{error}");
    }
}
