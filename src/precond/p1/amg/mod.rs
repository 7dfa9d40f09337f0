//! Smoothed-aggregation algebraic multigrid for A11.
//!
//! Levels A_0 = A11, A_(l+1) = P_l^T A_l P_l. Strongly coupled vertices form
//! groups (`strength`, `aggregate`), each group carries the rigid-body modes
//! (`modes`), the prolongator P is smoothed by one Jacobi step (`prolongate`).
//! The W-cycle smooths by Chebyshev steps around block Jacobi (`smoother`) and
//! inverts the coarsest matrix (`coarsest`). It is symmetric positive definite.
//!
//! Vanek, Mandel and Brezina, Algebraic multigrid by smoothed aggregation for
//! second and fourth order elliptic problems, Computing 56 (1996). Set-up and
//! cycle are O(vertices): on tetrahedra, in `f32` and on one core, 1.4 kB, 9 us
//! of set-up and 0.27 us of each cycle per vertex; contact: `columns`. Every result has the same bits
//! for any number of threads.

mod aggregate;
mod block_rows;
mod coarsest;
mod columns;
mod cycle;
mod galerkin;
mod modes;
mod prolongate;
mod setup;
mod smoother;
mod strength;

use super::Traces;
use crate::linalg::Scalar;
use crate::linalg::cholesky::Precision;
use crate::linalg::vector::{largest, power_of_two_below};
use crate::linalg::{DenseMatrix, FactoriseError, Held, LinearOperator, Preconditioner, Workspace};
use crate::precond::spectrum::{Interval, Lanczos};
use cycle::Hierarchy;

/// Lanczos steps that judge a finished hierarchy.
const TRIAL_STEPS: usize = 6;
/// A cycle whose condition is above this needs another solver.
const WORST_CONDITION: f64 = 30.0;
/// In exact arithmetic no eigenvalue of cycle times matrix is above one; on flat
/// cells (aspect 100) single precision overshoots to 2.4 and doubles the count.
const OVERSHOOT: f64 = 1.3;

/// The P1 stiffness by vertices and edges, held components not yet eliminated.
#[derive(Clone, Copy, Debug)]
pub struct VertexBlocks<'a> {
    /// Components of a vertex: 2 or 3.
    pub components: usize,
    /// Undeformed position of each vertex `[vertices]`, from which the rigid modes are
    /// taken.
    pub coordinates: &'a [[f64; 3]],
    /// Lower and upper end of each edge, in lexicographic order.
    pub edges: &'a [[u32; 2]],
    /// Diagonal block of each vertex `[vertices]`, padded to three components.
    pub diagonal: &'a [[[f64; 3]; 3]],
    /// Block of each edge: rows of the lower end, columns of the upper one.
    pub off: &'a [[[f64; 3]; 3]],
    /// Held unknowns; others than those of vertices are passed over.
    pub held: &'a Held,
}

/// Why there is no usable hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum AmgError {
    /// The matrix is not positive, or the cycle is not so or overshoots in the
    /// chosen precision.
    #[error("the multigrid cycle is not positive definite in this precision")]
    Indefinite,
    /// Too few vertices are strongly coupled, so that the next level would not be much
    /// smaller.
    #[error("{nodes} nodes form {groups} groups, too many for a next level")]
    Stalled {
        /// Nodes of the level.
        nodes: usize,
        /// Groups found.
        groups: usize,
    },
    /// The cycle does not reduce the error of this matrix fast enough to be of use.
    #[error("the multigrid cycle leaves a condition of {condition:.0}")]
    Weak {
        /// Ratio of the Ritz values of cycle times matrix.
        condition: f64,
    },
    /// The matrix of the coarsest level has no Cholesky factor.
    #[error("coarsest level: {0}")]
    Coarsest(#[from] FactoriseError),
}

/// One level as reports show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelShape {
    /// Number of nodes: vertices on the finest level, groups below.
    pub nodes: usize,
    /// Number of stored blocks.
    pub blocks: usize,
    /// Rows of a block: components of a vertex, or modes of a group.
    pub components: usize,
}

/// A hierarchy whose block sizes are no longer part of its type.
trait Cycle: Preconditioner {
    /// The matrix of the finest level `[unknowns, unknowns]`.
    fn matrix(&self) -> &dyn LinearOperator;
    /// All levels, finest first, as reports show them.
    fn levels(&self) -> Vec<LevelShape>;
    /// Bytes that the hierarchy holds.
    fn held_bytes(&self) -> u64;
    /// The inverse between the traces `[traces, traces]` by one V-cycle; none where
    /// `proceed` says stop.
    fn compliance(
        &self,
        traces: &Traces<'_>,
        proceed: &(dyn Fn() -> bool + Sync),
    ) -> Option<DenseMatrix>;
}

/// A multigrid W-cycle for A11.
pub struct AmgP1 {
    /// The hierarchy for the body's number of components.
    cycle: Box<dyn Cycle>,
    /// Extreme Ritz values of the preconditioned matrix, measured when the hierarchy
    /// was made.
    interval: Interval,
}

impl std::fmt::Debug for AmgP1 {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("AmgP1")
            .field("levels", &self.levels())
            .field("interval", &self.interval)
            .finish_non_exhaustive()
    }
}

impl AmgP1 {
    /// Builds the hierarchy of `blocks` and tries it.
    ///
    /// # Errors
    /// [`AmgError`] when the cycle is not positive or too weak.
    pub fn new(blocks: &VertexBlocks<'_>, precision: Precision) -> Result<Self, AmgError> {
        let cycle: Box<dyn Cycle> = match (blocks.components, precision) {
            (2, Precision::Single) => Box::new(setup::hierarchy::<f32, 2, 3>(blocks)?),
            (2, Precision::Double) => Box::new(setup::hierarchy::<f64, 2, 3>(blocks)?),
            (_, Precision::Single) => Box::new(setup::hierarchy::<f32, 3, 6>(blocks)?),
            (_, Precision::Double) => Box::new(setup::hierarchy::<f64, 3, 6>(blocks)?),
        };
        let work = &mut Workspace::new();
        let lanczos = Lanczos {
            operator: cycle.matrix(),
            preconditioner: &*cycle,
            held: Some(blocks.held),
            steps: TRIAL_STEPS,
        };
        let interval = lanczos.interval(work);
        judge(interval)?;
        Ok(Self { cycle, interval })
    }

    /// Ritz interval of cycle times matrix, from a few steps.
    pub fn interval(&self) -> Interval {
        self.interval
    }

    /// All levels but the coarsest.
    pub fn levels(&self) -> Vec<LevelShape> {
        self.cycle.levels()
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        self.cycle.held_bytes()
    }

    /// About A11^-1 on `traces`, that of one V-cycle; none when `proceed` says no on
    /// the way.
    pub fn compliance(
        &self,
        traces: &Traces<'_>,
        proceed: &(dyn Fn() -> bool + Sync),
    ) -> Option<DenseMatrix> {
        self.cycle.compliance(traces, proceed)
    }
}

impl Preconditioner for AmgP1 {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        self.cycle.apply(r, z, work);
    }
}

/// Refuses a cycle that would not serve conjugate gradients well.
fn judge(interval: Interval) -> Result<(), AmgError> {
    let condition = interval.largest / interval.smallest;
    let is_sound = interval.smallest > 0.0 && interval.largest < OVERSHOOT;
    if !(is_sound && condition.is_finite()) {
        return Err(AmgError::Indefinite);
    }
    if condition > WORST_CONDITION {
        return Err(AmgError::Weak { condition });
    }
    Ok(())
}

impl<S: Scalar, const N: usize, const K: usize> Cycle for Hierarchy<S, N, K> {
    fn matrix(&self) -> &dyn LinearOperator {
        &self.finest.matrix
    }

    fn levels(&self) -> Vec<LevelShape> {
        let shapes = self.shape().into_iter().enumerate();
        let level = |(depth, (nodes, blocks))| LevelShape {
            nodes,
            blocks,
            components: if depth == 0 { N } else { K },
        };
        shapes.map(level).collect()
    }

    fn held_bytes(&self) -> u64 {
        self.bytes()
    }

    fn compliance(
        &self,
        traces: &Traces<'_>,
        proceed: &(dyn Fn() -> bool + Sync),
    ) -> Option<DenseMatrix> {
        columns::compliance(self, traces, proceed)
    }
}

impl<S: Scalar, const N: usize, const K: usize> Preconditioner for Hierarchy<S, N, K> {
    /// The residual is scaled by a power of two into the middle of the range
    /// of `f32`, so that no size of load under- or overflows.
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let size = largest(r);
        if size == 0.0 || !size.is_finite() {
            return z.fill(size);
        }
        let scale = power_of_two_below(size);
        let mut residual = S::take(work, r.len());
        let mut x = S::take(work, r.len());
        for (to, from) in residual.iter_mut().zip(r) {
            *to = S::narrow(from / scale);
        }
        self.cycle(&mut residual, &mut x, work);
        for (to, from) in z.iter_mut().zip(&x) {
            *to = from.widen() * scale;
        }
        S::give(work, residual);
        S::give(work, x);
    }
}

#[cfg(test)]
mod tests;
