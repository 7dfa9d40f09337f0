//! Two-level p-multigrid for the P2 stiffness: Chebyshev smoothing around node
//! blocks, exact or approximate P1 correction, the same smoothing again.
//!
//! Input and output are in the hierarchical basis (vertices, then edge
//! corrections). The smoother works on Lagrange node values
//! u_e + (u_a + u_b)/2, where it needs half the iterations. One application of
//! degree k costs 2k operator products and one P1 solve; it is symmetric
//! positive definite, with condition about 2.2 (k = 2) or 1.7 (k = 3) on good
//! tetrahedra, independent of the mesh size.

use std::sync::Arc;

use super::spectrum::Lanczos;
use super::{NodeBlocks, Transfer};
use crate::linalg::vector::add_scaled;
use crate::linalg::{LinearOperator, Preconditioner, Workspace};

/// The smoother damps `[largest / ratio, largest]`; a higher degree reaches deeper.
fn ratio(degree: usize) -> f64 {
    match degree {
        0..=2 => 6.0,
        3 => 10.0,
        4..=5 => 16.0,
        6..=7 => 30.0,
        _ => 60.0,
    }
}
/// Lanczos steps for the largest eigenvalue.
const LANCZOS_STEPS: usize = 12;
/// The Lanczos process approaches the largest eigenvalue from below.
const SAFETY: f64 = 1.05;

/// The preconditioner of the displacement block.
pub struct PMultigrid {
    /// A in the hierarchical basis `[unknowns, unknowns]`.
    operator: Arc<dyn LinearOperator>,
    /// Inverted Lagrange node blocks, which the Chebyshev smoother steps in.
    smoother: NodeBlocks,
    /// Approximate inverse of A11 for the coarse correction.
    coarse: Arc<dyn Preconditioner>,
    /// The way between the hierarchical basis and Lagrange's, and to the vertices.
    transfer: Transfer,
    /// Degree of the Chebyshev smoother before and behind the correction.
    degree: usize,
    /// Largest eigenvalue of the smoother's product with A, the upper end of its
    /// interval.
    largest: f64,
}

impl PMultigrid {
    /// `operator` acts on Lagrange values; `smoother` holds its inverted node
    /// blocks and takes steps of `degree`; `coarse` solves P1. Estimates the largest eigenvalue.
    pub fn new(
        operator: Arc<dyn LinearOperator>,
        (smoother, degree): (NodeBlocks, usize),
        coarse: Arc<dyn Preconditioner>,
        transfer: Transfer,
    ) -> Self {
        let lanczos = Lanczos {
            operator: &*operator,
            preconditioner: &smoother,
            held: transfer.held(),
            steps: LANCZOS_STEPS,
        };
        let interval = lanczos.interval(&mut Workspace::new());
        Self {
            operator,
            smoother,
            coarse,
            transfer,
            degree,
            largest: SAFETY * interval.largest,
        }
    }

    /// Operator applications that construction took.
    pub fn estimate_applications() -> u32 {
        LANCZOS_STEPS as u32
    }

    /// Bytes held by the node blocks and the incidence.
    pub fn bytes(&self) -> u64 {
        self.smoother.bytes() + self.transfer.bytes()
    }

    /// `degree` Chebyshev steps on `x` with running residual `r`; the residual
    /// of the last step is computed only where `products` asks for it.
    fn smooth(&self, x: &mut [f64], r: &mut [f64], products: usize, work: &mut Workspace) {
        let (low, high) = (self.largest / ratio(self.degree), self.largest);
        let (centre, half) = (0.5 * (high + low), 0.5 * (high - low));
        let sigma = centre / half;
        let mut rho = 1.0 / sigma;
        let (mut keep, mut gain) = (0.0, 1.0 / centre);
        let mut direction = work.zeros(r.len());
        for step in 0..self.degree {
            self.smoother
                .chebyshev_update((keep, gain), r, &mut direction, x);
            if step < products {
                self.operator.subtract_product(&direction, r, work);
            }
            let next = 1.0 / (2.0 * sigma - rho);
            (keep, gain) = (next * rho, 2.0 * next / half);
            rho = next;
        }
        work.give(direction);
    }

    /// Adds the correction of the P1 block to `x` and takes its product off the
    /// residual `r`. Cost: one P1 solve and one product with A.
    fn correct_coarse(&self, x: &mut [f64], r: &mut [f64], work: &mut Workspace) {
        let size = self.transfer.coarse_size();
        let mut coarse_residual = work.scratch(size);
        let mut coarse = work.scratch(size);
        self.transfer.restrict(r, &mut coarse_residual);
        self.coarse.apply(&coarse_residual, &mut coarse, work);
        let mut fine = work.scratch(r.len());
        self.transfer.prolong(&coarse, &mut fine);
        self.operator.subtract_product(&fine, r, work);
        add_scaled(x, 1.0, &fine);
        for vector in [coarse_residual, coarse, fine] {
            work.give(vector);
        }
    }
}

impl Preconditioner for PMultigrid {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let mut residual = work.copy(r);
        self.transfer.residual_to_lagrange(&mut residual);
        z.fill(0.0);
        self.smooth(z, &mut residual, self.degree, work);
        self.correct_coarse(z, &mut residual, work);
        self.smooth(z, &mut residual, self.degree - 1, work);
        self.transfer.values_to_hierarchical(z);
        work.give(residual);
    }
}
