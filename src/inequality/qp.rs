//! The words of a quadratic program with non-negative multipliers: iterate,
//! norms, scales, targets, outcome.

use crate::krylov::{Outcome, Verdict};

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

/// Outcome and counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QpOutcome {
    /// Why it ended.
    pub status: QpStatus,
    /// Krylov iterations, one displacement preconditioner application each.
    pub iterations: u32,
    /// Preconditioner applications outside the Krylov iterations.
    pub predictions: u32,
    /// Revisions of the first set.
    pub set_changes: u32,
}

/// Sees every iteration; returns whether to go on.
pub type Progress<'a> = dyn FnMut(&QpNorms, &QpScales, usize) -> Verdict + 'a;
