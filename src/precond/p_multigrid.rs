//! Two-level p-multigrid for the P2 stiffness: an exact or approximate P1 correction, and Chebyshev
//! smoothing in node blocks around or after it.
//!
//! Input and output are in the hierarchical basis (vertices, then edge
//! corrections). The smoother works on Lagrange node values
//! u_e + (u_a + u_b)/2, where it needs half the iterations. With k steps before and k after, an
//! application costs 2k operator products and one P1 solve; it is symmetric
//! positive definite up to rounding, with condition about 2.2 (k = 2) or 1.7 (k = 3) on good
//! tetrahedra, independent of the mesh size. With k steps after alone it costs k products and is
//! not symmetric: for methods that do not ask for that, 3 steps do the work of 2 and 2.
//!
//! Between its ends all vectors are in the numbers R: in single precision half the bytes
//! move, and the outer method, which is flexible, makes good what rounding leaves.

use std::sync::Arc;

use super::chebyshev::{Chebyshev, Step};
use super::spectrum::Lanczos;
use super::{NodeBlocks, Transfer};
use crate::linalg::vector::{norm, power_of_two_below};
use crate::linalg::{Held, LinearOperator, Preconditioner, ResidualUpdate, Scalar, Workspace};

/// Lanczos steps for the largest eigenvalue, each of which takes a product with A.
pub const LANCZOS_STEPS: usize = 12;
/// The Lanczos process approaches the largest eigenvalue from below.
const SAFETY: f64 = 1.05;

/// Chebyshev steps and their place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Smoothing {
    /// So many before the P1 correction, and as many after it.
    Around(usize),
    /// So many after it.
    After(usize),
}

impl std::fmt::Display for Smoothing {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Around(steps) => write!(out, "Chebyshev degree {steps}"),
            Self::After(steps) => write!(out, "{steps} Chebyshev steps after the P1 solve"),
        }
    }
}

impl Smoothing {
    /// Steps of one smoothing.
    fn steps(self) -> usize {
        match self {
            Self::Around(steps) | Self::After(steps) => steps,
        }
    }

    /// The smoother damps `[largest / ratio, largest]`; a higher degree reaches deeper, two smoothings
    /// deeper than one.
    fn ratio(self) -> f64 {
        match self {
            Self::Around(0..=2) => 6.0,
            Self::After(0..=3) => 7.0,
            Self::Around(3) => 10.0,
            Self::Around(4..=5) | Self::After(4..=5) => 16.0,
            Self::Around(6..=7) | Self::After(6..=7) => 30.0,
            Self::Around(_) | Self::After(_) => 60.0,
        }
    }
}

/// The preconditioner of the displacement block.
pub struct PMultigrid<R> {
    /// A on Lagrange values `[unknowns, unknowns]`.
    operator: Arc<dyn ResidualUpdate<R>>,
    /// Chebyshev smoother on Lagrange values.
    smoother: Smoother,
    /// Approximate inverse of A11 for the coarse correction.
    coarse: Arc<dyn Preconditioner>,
    /// The way between the hierarchical basis and Lagrange's, and to the vertices.
    transfer: Transfer,
}

/// Chebyshev steps in node blocks.
pub struct Smoother {
    /// Inverted Lagrange node blocks.
    pub blocks: NodeBlocks,
    /// The steps and their place.
    pub smoothing: Smoothing,
    /// Largest eigenvalue of the blocks' product with A, the upper end of the interval.
    pub largest: f64,
}

/// The largest eigenvalue of the product of `smoother` with A, which acts on Lagrange values with
/// vanishing where it is `held`; a little more, as the Lanczos process approaches it from below.
pub fn largest_eigenvalue(
    operator: &dyn LinearOperator,
    smoother: &NodeBlocks,
    held: &Held,
) -> f64 {
    let lanczos = Lanczos {
        operator,
        preconditioner: smoother,
        held: Some(held),
        steps: LANCZOS_STEPS,
    };
    SAFETY * lanczos.interval(&mut Workspace::new()).largest
}

impl<R: Scalar> PMultigrid<R> {
    /// `operator` acts on Lagrange values, `smoother` steps in its node blocks; `coarse` solves P1.
    pub fn new(
        operator: Arc<dyn ResidualUpdate<R>>,
        smoother: Smoother,
        coarse: Arc<dyn Preconditioner>,
        transfer: Transfer,
    ) -> Self {
        Self {
            operator,
            smoother,
            coarse,
            transfer,
        }
    }

    /// Bytes held by the node blocks and the incidence.
    pub fn bytes(&self) -> u64 {
        self.smoother.blocks.bytes() + self.transfer.bytes()
    }

    /// The Chebyshev steps on `x` with running residual `r` and direction `d`, beginning as
    /// `start` says; the residual of the last step is computed only where a correction follows.
    fn smooth(
        &self,
        (x, r, d): (&mut [R], &mut [R], &mut [R]),
        start: Start,
        work: &mut Workspace,
    ) {
        let Smoother {
            blocks,
            smoothing,
            largest,
        } = &self.smoother;
        let steps = smoothing.steps();
        let mut chebyshev = Chebyshev::new(largest / smoothing.ratio(), *largest);
        for step in 0..steps {
            let Step { keep, gain } = chebyshev.advance();
            match (step, start) {
                (0, Start::FromNothing) => blocks.chebyshev_start(gain, r, d, x),
                (0, Start::AfterCorrection) => blocks.chebyshev_restart(gain, r, d, x),
                _ => blocks.chebyshev_update((keep, gain), r, d, x),
            }
            if step + 1 < steps || start == Start::FromNothing {
                self.operator.update_residual(d, r, work);
            }
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
        self.operator.update_residual(fine, r, work);
        work.give(coarse_residual);
        work.give(coarse);
    }
}

/// Where a smoothing begins.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Start {
    /// At x = 0.
    FromNothing,
    /// At x + d.
    AfterCorrection,
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
        match self.smoother.smoothing {
            Smoothing::Around(_) => {
                self.smooth((x, r, d), Start::FromNothing, work);
                self.coarse_correction(r, d, work);
            }
            Smoothing::After(_) => {
                self.coarse_correction(r, d, work);
                x.fill(R::default());
            }
        }
        self.smooth((x, r, d), Start::AfterCorrection, work);
        self.transfer.values_to_hierarchical(unit, x, z);
        for vector in [residual, direction, values] {
            R::give(work, vector);
        }
    }
}
