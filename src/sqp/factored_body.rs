//! The body of a program by a factor of its saddle point K, with the compliance W of its contact:
//! what `program::by_factor` makes and later programs may use.

use std::sync::atomic::{AtomicU32, Ordering};

use super::near_compliance::NearCompliance;
use crate::inequality::{BodyFactor, FactorStep};
use crate::linalg::Workspace;

/// K and W.
#[derive(Debug)]
pub(crate) struct FactoredBody {
    /// K.
    factor: BodyFactor,
    /// W.
    pub(super) compliance: NearCompliance,
    /// Solutions with it since the present solve began.
    pub(super) solutions: AtomicU32,
}

impl FactoredBody {
    /// Of a factor and the compliance by it.
    pub(super) fn new(factor: BodyFactor, compliance: NearCompliance) -> Self {
        Self {
            factor,
            compliance,
            solutions: AtomicU32::new(0),
        }
    }

    /// Whether K is that of the body: no motion was turned.
    pub(super) fn is_exact(&self) -> bool {
        self.factor.is_exact()
    }

    /// Counts from zero again.
    pub(super) fn begin(&self) {
        self.solutions.store(0, Ordering::Relaxed);
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        self.factor.bytes() + self.compliance.bytes()
    }

    /// The step of GCR.
    pub(super) fn step(&self) -> FactorStep<'_> {
        FactorStep {
            body: &self.factor,
            solutions: &self.solutions,
        }
    }

    /// K^-1 of a force and a residual of the volumes, as one vector.
    pub(super) fn solve(
        &self,
        force: &[f64],
        constraint: &[f64],
        work: &mut Workspace,
    ) -> Vec<f64> {
        let mut solution = [force, constraint].concat();
        self.factor.solve(&mut solution, work);
        self.solutions.fetch_add(1, Ordering::Relaxed);
        solution
    }
}
