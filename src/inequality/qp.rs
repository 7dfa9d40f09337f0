//! The words of a quadratic program with non-negative multipliers: problem,
//! iterate, norms, scales, targets, outcome.

use crate::krylov::{Outcome, Verdict, gcr};
use crate::linalg::{DenseMatrix, LinearOperator, Preconditioner, SparseRows, Workspace};
use crate::saddle::{BlockStep, MultiplierBlock};

/// The problem; shapes as in the equation of [`super::one_level`].
#[derive(Clone, Copy)]
pub struct QpProblem<'a> {
    /// A without `curvature`.
    pub stiffness: &'a dyn LinearOperator,
    /// What the multipliers take off A; none where the gap is linear.
    pub curvature: Option<&'a SparseRows>,
    /// Approximate inverse of A.
    pub displacement: &'a dyn Preconditioner,
    /// How multipliers and displacement are stepped.
    pub step: BlockStep,
    /// Equality blocks: the internal pressure, or none.
    pub equality: &'a [MultiplierBlock<'a>],
    /// C.
    pub coupling: &'a SparseRows,
    /// Metric of the multiplier; without rows where the weights are all of it.
    pub metric: &'a DenseMatrix,
    /// Lumped mass of the multiplier, scaled like the metric `[multipliers]`;
    /// empty for methods that do not read it.
    pub weights: &'a [f64],
}

/// What a solve may use, and who follows it.
pub struct QpRun<'a, 'b> {
    /// When the problem counts as solved.
    pub targets: QpTargets,
    /// Grow with the norms seen.
    pub scales: &'a mut QpScales,
    /// Krylov iterations: of the whole solve on one level, of each inner solve
    /// of a nested method.
    pub iterations: u32,
    /// Kept from earlier problems with the same A and equality blocks.
    pub directions: &'a mut gcr::Directions,
    /// Called after every Krylov iteration.
    pub progress: &'a mut Progress<'b>,
    /// Scratch.
    pub work: &'a mut Workspace,
}

/// Iterate and residuals; on entry the increments are zero.
#[derive(Clone, Debug, Default)]
pub struct QpIterate {
    /// du.
    pub displacement: Vec<f64>,
    /// dx.
    pub equality: Vec<f64>,
    /// l.
    pub multiplier: Vec<f64>,
    /// f - A du - B^T dx - C^T l; on entry with the entry's l taken off.
    pub force: Vec<f64>,
    /// g - B du + S dx.
    pub constraint: Vec<f64>,
    /// gap - C du.
    pub gap: Vec<f64>,
    /// Vertices in contact.
    pub active: Vec<bool>,
}

/// Norms of the residual blocks on the current face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QpNorms {
    /// Of the force.
    pub force: f64,
    /// Of the equality constraint.
    pub constraint: f64,
    /// Of the gap on the active set.
    pub gap: f64,
}

/// Scales of the blocks that have no load of their own: the largest norms seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QpScales {
    /// Of the equality constraint.
    pub constraint: f64,
    /// Of the gap.
    pub gap: f64,
}

impl QpScales {
    /// Takes larger norms over.
    pub fn see(&mut self, constraint: f64, gap: f64) {
        self.constraint = self.constraint.max(constraint);
        self.gap = self.gap.max(gap);
    }
}

/// When the problem counts as solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QpTargets {
    /// Norm of the force that counts as one.
    pub force_scale: f64,
    /// Bound on all norms over their scales.
    pub level: f64,
}

impl QpNorms {
    /// The largest norm over its scale.
    pub fn relative(&self, force_scale: f64, scales: &QpScales) -> f64 {
        let ratio = |value: f64, scale: f64| match value == 0.0 {
            true => 0.0,
            false => value / scale.max(f64::MIN_POSITIVE),
        };
        ratio(self.force, force_scale)
            .max(ratio(self.constraint, scales.constraint))
            .max(ratio(self.gap, scales.gap))
    }
}

/// Why the solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QpStatus {
    /// Targets reached on the right set.
    Solved,
    /// The caller asked to stop.
    Interrupted,
    /// The set returned to an earlier one at full accuracy.
    ActiveSetCycle,
    /// The compliance is not positive definite.
    IndefiniteMetric,
    /// The Krylov method failed.
    Krylov(Outcome),
}

impl QpStatus {
    /// How a Krylov solve failed; none where its monitor stopped it.
    pub fn failure(outcome: Outcome) -> Option<Self> {
        match outcome {
            Outcome::Stopped => None,
            Outcome::IterationLimit
            | Outcome::Stagnation
            | Outcome::NotFinite
            | Outcome::Indefinite => Some(Self::Krylov(outcome)),
        }
    }
}

/// Outcome and counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QpOutcome {
    /// Why it ended.
    pub status: QpStatus,
    /// Krylov iterations, one displacement preconditioner application each.
    pub iterations: u32,
    /// Preconditioner applications outside the Krylov iterations.
    pub predictions: u32,
    /// Products with C S^-1 C^T, one inner solve each; none on one level.
    pub products: u32,
    /// Revisions of the first set.
    pub set_changes: u32,
}

impl QpOutcome {
    /// Nothing counted.
    pub fn new(status: QpStatus) -> Self {
        Self {
            status,
            iterations: 0,
            predictions: 0,
            products: 0,
            set_changes: 0,
        }
    }
}

/// Sees every iteration; returns whether to go on.
pub type Progress<'a> = dyn FnMut(&QpNorms, &QpScales, usize) -> Verdict + 'a;
