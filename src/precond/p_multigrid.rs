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

    /// `degree` Chebyshev steps on `x` with running residual `r` and direction `d`, beginning as
    /// `start` says; the residual of the last step is computed only where `products` asks for it.
    fn smooth(
        &self,
        (x, r, d): (&mut [f64], &mut [f64], &mut [f64]),
        start: Start,
        products: usize,
        work: &mut Workspace,
    ) {
        let (low, high) = (self.largest / ratio(self.degree), self.largest);
        let (centre, half) = (0.5 * (high + low), 0.5 * (high - low));
        let sigma = centre / half;
        let mut rho = 1.0 / sigma;
        let (mut keep, mut gain) = (0.0, 1.0 / centre);
        for step in 0..self.degree {
            match (step, start) {
                (0, Start::FromNothing) => self.smoother.chebyshev_start(gain, r, d, x),
                (0, Start::BehindCorrection) => self.smoother.chebyshev_restart(gain, r, d, x),
                _ => self.smoother.chebyshev_update((keep, gain), r, d, x),
            }
            if step < products {
                self.operator.subtract_product(d, r, work);
            }
            let next = 1.0 / (2.0 * sigma - rho);
            (keep, gain) = (next * rho, 2.0 * next / half);
            rho = next;
        }
    }

    /// The correction `fine` of the P1 block, whose product it takes off the residual `r`. Cost:
    /// one P1 solve and one product with A.
    fn coarse_correction(&self, r: &mut [f64], fine: &mut [f64], work: &mut Workspace) {
        let size = self.transfer.coarse_size();
        let mut coarse_residual = work.scratch(size);
        let mut coarse = work.scratch(size);
        self.transfer.restrict(r, &mut coarse_residual);
        self.coarse.apply(&coarse_residual, &mut coarse, work);
        self.transfer.prolong(&coarse, fine);
        self.operator.subtract_product(fine, r, work);
        work.give(coarse_residual);
        work.give(coarse);
    }
}

/// Where a smoothing begins.
#[derive(Clone, Copy)]
enum Start {
    /// At x = 0.
    FromNothing,
    /// At x + d.
    BehindCorrection,
}

impl Preconditioner for PMultigrid {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let mut residual = work.copy(r);
        let mut direction = work.scratch(r.len());
        self.transfer.residual_to_lagrange(&mut residual);
        let (r, d) = (&mut residual[..], &mut direction[..]);
        self.smooth((z, r, d), Start::FromNothing, self.degree, work);
        self.coarse_correction(r, d, work);
        self.smooth((z, r, d), Start::BehindCorrection, self.degree - 1, work);
        self.transfer.values_to_hierarchical(z);
        work.give(residual);
        work.give(direction);
    }
}
