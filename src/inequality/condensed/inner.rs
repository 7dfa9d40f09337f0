//! The monitor of an inner solve: bounds on the residuals of force and constraint.

use super::super::qp::{Progress, QpNorms, QpScales};
use crate::krylov::{Monitor, Verdict};
use crate::linalg::vector::norm;

/// Of the force residual, and of the constraint against its largest value.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub(super) force: f64,
    pub(super) constraint: f64,
}

pub(super) struct InnerMonitor<'a, 'b> {
    pub(super) displacement: usize,
    pub(super) bounds: Bounds,
    /// Largest constraint residual so far.
    pub(super) peak: f64,
    pub(super) iterations: u32,
    pub(super) reached: bool,
    pub(super) interrupted: bool,
    /// Of the outer iterate.
    pub(super) outer: QpNorms,
    pub(super) active: usize,
    pub(super) scales: QpScales,
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
        match self.reached {
            true => Verdict::Stop,
            false => Verdict::Continue,
        }
    }
}
