//! The monitor of an inner solve: bounds on the residuals of force and constraint.

use super::super::qp::{Progress, QpNorms, QpScales};
use crate::krylov::{Monitor, Verdict};
use crate::linalg::vector::norm;

/// Of the force residual, and of the constraint against its largest value.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    /// Bound on the norm of the force residual, non-dimensional.
    pub(super) force: f64,
    /// Bound on the norm of the constraint residual over its largest value so far.
    pub(super) constraint: f64,
}

/// Follows the inner Krylov iterations of one product with the exact compliance.
pub(super) struct InnerMonitor<'a, 'b> {
    /// Number of displacement unknowns, which come first in the packed residual.
    pub(super) displacement: usize,
    /// Where the inner solve ends.
    pub(super) bounds: Bounds,
    /// Largest norm of the constraint residual so far, non-dimensional.
    pub(super) peak: f64,
    /// Krylov iterations of this product so far.
    pub(super) iterations: u32,
    /// Whether the bounds were reached.
    pub(super) reached: bool,
    /// Whether the caller has asked to stop.
    pub(super) interrupted: bool,
    /// Norms for reports: the gap is that of the outer iterate, force and constraint
    /// are those of the inner solve.
    pub(super) outer: QpNorms,
    /// Number of closed multipliers of the outer iterate, for reports.
    pub(super) active: usize,
    /// Scales of the blocks, for reports.
    pub(super) scales: QpScales,
    /// Told of every Krylov iteration; its answer may stop the solve.
    pub(super) progress: &'a mut Progress<'b>,
}

impl InnerMonitor<'_, '_> {
    /// Whether the bounds are reached.
    pub(super) fn measure(&mut self, residual: &[f64]) -> bool {
        let (force, constraint) = residual.split_at(self.displacement);
        (self.outer.force, self.outer.constraint) = (norm(force), norm(constraint));
        self.peak = self.peak.max(self.outer.constraint);
        self.outer.force <= self.bounds.force
            && self.outer.constraint <= self.bounds.constraint * self.peak
    }
}

impl Monitor for InnerMonitor<'_, '_> {
    fn judge(&mut self, residual: &[f64]) -> Verdict {
        self.iterations += 1;
        self.reached = self.measure(residual);
        if (self.progress)(&self.outer, &self.scales, self.active) == Verdict::Stop {
            self.interrupted = true;
            return Verdict::Stop;
        }
        if self.reached {
            Verdict::Stop
        } else {
            Verdict::Continue
        }
    }
}
