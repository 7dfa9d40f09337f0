//! Follows the Krylov iterations on a face: block norms of the residual, the targets, and
//! when the face is reviewed. Cost: a few norms an iteration.

use super::super::qp::{Progress, QpNorms, QpScales, QpTargets};
use super::GAP_WEIGHT;
use super::augmented::Augmented;
use super::weights::unweigh;
use crate::krylov::{Monitor, Verdict};
use crate::linalg::Workspace;
use crate::linalg::vector::{norm, scale};

/// When the active set is reviewed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Review {
    /// As soon as the residual has fallen by a fixed factor: the first faces are rarely
    /// the right ones.
    WhenReduced,
    /// Only when the linear system of the face is solved to its target.
    AtTheEnd,
}

/// Follows the Krylov iterations of one face and says when it has been solved, or
/// reviewed early.
pub(super) struct FaceMonitor<'a, 'b> {
    /// Number of displacement unknowns, which come first in the packed residual.
    pub(super) displacement: usize,
    /// Number of equality unknowns, which follow them.
    pub(super) equality: usize,
    /// Moduli that weigh the gaps after these; empty where all are one.
    pub(super) moduli: &'a [f64],
    /// What the residual of the forces was augmented by; none where nothing was.
    pub(super) augmented: Option<&'a Augmented<'a>>,
    /// When the problem counts as solved.
    pub(super) targets: QpTargets,
    /// Scales of the blocks; they grow with the norms that this face shows.
    pub(super) scales: &'a mut QpScales,
    /// How far they may grow.
    pub(super) largest: QpScales,
    /// When the face is reviewed.
    pub(super) review: Review,
    /// Reduction of the residual after which it is, where not at the end.
    pub(super) reduction: f64,
    /// Largest relative norm at the start of the face, which a review while reducing is
    /// measured against.
    pub(super) start: f64,
    /// Krylov iterations on the face so far.
    pub(super) iterations: u32,
    /// Whether the targets were reached.
    pub(super) reached: bool,
    /// Whether the caller has asked to stop.
    pub(super) interrupted: bool,
    /// Number of closed multipliers of the face, for reports.
    pub(super) active: usize,
    /// Told of every Krylov iteration; its answer may stop the solve.
    pub(super) progress: &'a mut Progress<'b>,
}

impl FaceMonitor<'_, '_> {
    /// Norm of the forces of the system as it stands: an augmented one may be small where
    /// it is not.
    fn force_norm(&self, force: &[f64], weighted: &[f64]) -> f64 {
        let Some(augmented) = self.augmented else {
            return norm(force);
        };
        let mut gap = weighted.to_vec();
        unweigh(self.moduli, &mut gap);
        scale(&mut gap, 1.0 / GAP_WEIGHT);
        let mut own = force.to_vec();
        augmented.add_force(-1.0, &gap, (&mut own, &mut Workspace::new()));
        norm(&own)
    }

    /// Norm of the gaps without their moduli.
    fn gap_norm(&self, weighted: &[f64]) -> f64 {
        if self.moduli.is_empty() {
            return norm(weighted);
        }
        let mut gap = weighted.to_vec();
        unweigh(self.moduli, &mut gap);
        norm(&gap)
    }

    /// Block norms and the largest over its scale.
    pub(super) fn measure(&mut self, r: &[f64]) -> (QpNorms, f64) {
        let (force, rest) = r.split_at(self.displacement);
        let (constraint, gap) = rest.split_at(self.equality);
        let norms = QpNorms {
            force: self.force_norm(force, gap),
            constraint: norm(constraint),
            gap: self.gap_norm(gap) / GAP_WEIGHT,
        };
        let bound = self.largest;
        let (constraint, gap) = (norms.constraint, norms.gap);
        self.scales
            .see(constraint.min(bound.constraint), gap.min(bound.gap));
        (norms, norms.relative(self.targets.force_scale, self.scales))
    }
}

impl Monitor for FaceMonitor<'_, '_> {
    fn judge(&mut self, residual: &[f64]) -> Verdict {
        self.iterations += 1;
        let (norms, relative) = self.measure(residual);
        self.reached = relative <= self.targets.level;
        if (self.progress)(&norms, self.scales, self.active) == Verdict::Stop {
            self.interrupted = true;
            return Verdict::Stop;
        }
        let review = self.review == Review::WhenReduced && relative <= self.reduction * self.start;
        if self.reached || review {
            Verdict::Stop
        } else {
            Verdict::Continue
        }
    }
}
