//! Two-level p-multigrid for the P2 stiffness: Chebyshev smoothing around node
//! blocks, exact or approximate P1 correction, the same smoothing again.
//!
//! Input and output are in the hierarchical basis (vertices, then edge
//! corrections). The smoother works on Lagrange node values
//! u_e + (u_a + u_b)/2, where it needs half the iterations. One application of
//! degree k costs 2k operator products and one P1 solve; it is symmetric
//! positive definite up to rounding, with condition about 2.2 (k = 2) or 1.7 (k = 3) on good
//! tetrahedra, independent of the mesh size.
//!
//! Between its ends all vectors are in the numbers R: in single precision half the bytes
//! move, and the outer method, which is flexible, makes good what rounding leaves.

use std::sync::Arc;

use super::spectrum::Lanczos;
use super::{NodeBlocks, Transfer};
use crate::linalg::vector::{norm, power_of_two_below};
use crate::linalg::{LinearOperator, Preconditioner, ResidualUpdate, Scalar, Workspace};

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
/// Lanczos steps for the largest eigenvalue, each of which takes a product with A.
pub const LANCZOS_STEPS: usize = 12;
/// The Lanczos process approaches the largest eigenvalue from below.
const SAFETY: f64 = 1.05;

/// The preconditioner of the displacement block.
pub struct PMultigrid<R> {
    /// A on Lagrange values `[unknowns, unknowns]`.
    operator: Arc<dyn ResidualUpdate<R>>,
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

/// The largest eigenvalue of the product of `smoother` with A, which acts on Lagrange values with
/// vanishing `held` entries; a little more, as the Lanczos process approaches it from below.
pub fn largest_eigenvalue(
    operator: &dyn LinearOperator,
    smoother: &NodeBlocks,
    held: &[u32],
) -> f64 {
    let lanczos = Lanczos {
        operator,
        preconditioner: smoother,
        held,
        steps: LANCZOS_STEPS,
    };
    SAFETY * lanczos.interval(&mut Workspace::new()).largest
}

impl<R: Scalar> PMultigrid<R> {
    /// `operator` acts on Lagrange values; `smoother` holds its inverted node
    /// blocks, takes steps of `degree` and damps up to `largest`; `coarse` solves P1.
    pub fn new(
        operator: Arc<dyn ResidualUpdate<R>>,
        (smoother, degree, largest): (NodeBlocks, usize, f64),
        coarse: Arc<dyn Preconditioner>,
        transfer: Transfer,
    ) -> Self {
        Self {
            operator,
            smoother,
            coarse,
            transfer,
            degree,
            largest,
        }
    }

    /// Bytes held by the node blocks and the incidence.
    pub fn bytes(&self) -> u64 {
        self.smoother.bytes() + self.transfer.bytes()
    }

    /// `degree` Chebyshev steps on `x` with running residual `r` and direction `d`, beginning as
    /// `start` says; the residual of the last step is computed only where `products` asks for it.
    fn smooth(
        &self,
        (x, r, d): (&mut [R], &mut [R], &mut [R]),
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
                self.operator.take_off(d, r, work);
            }
            let next = 1.0 / (2.0 * sigma - rho);
            (keep, gain) = (next * rho, 2.0 * next / half);
            rho = next;
        }
    }

    /// The correction `fine` of the P1 block, whose product it takes off the residual `r`. Cost:
    /// one P1 solve and one product with A.
    fn coarse_correction(&self, r: &mut [R], fine: &mut [R], work: &mut Workspace) {
        let size = self.transfer.coarse_size();
        let mut coarse_residual = work.scratch(size);
        let mut coarse = work.scratch(size);
        self.transfer.restrict(r, &mut coarse_residual);
        self.coarse.apply(&coarse_residual, &mut coarse, work);
        self.transfer.prolong(&coarse, fine);
        self.operator.take_off(fine, r, work);
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

impl<R: Scalar> Preconditioner for PMultigrid<R> {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let [mut residual, mut direction, mut values] =
            std::array::from_fn(|_| R::take(work, r.len()));
        // No size of load leaves the range of single precision.
        let unit = match norm(r) {
            size if size > 0.0 => power_of_two_below(size),
            _ => 1.0,
        };
        self.transfer
            .residual_to_lagrange(1.0 / unit, r, &mut residual);
        let (x, r, d) = (&mut values[..], &mut residual[..], &mut direction[..]);
        self.smooth((x, r, d), Start::FromNothing, self.degree, work);
        self.coarse_correction(r, d, work);
        self.smooth((x, r, d), Start::BehindCorrection, self.degree - 1, work);
        self.transfer.values_to_hierarchical(unit, x, z);
        for vector in [residual, direction, values] {
            R::give(work, vector);
        }
    }
}
