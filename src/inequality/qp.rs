//! The words of a quadratic program with multipliers in admissible sets: problem,
//! iterate, norms, scales, targets, outcome.
//!
//! Shapes and signs are those of the equation of [`super::one_level`]; an equality is a
//! block whose set is free, with a residual of zero. Norms are taken over scales: of the
//! force, that of the load; of a block, the largest norm seen.

use super::Augmentation;
use crate::krylov::{Outcome, Verdict, gcr};
use crate::linalg::vector::{ratio, worst};
use crate::linalg::{FactoriseError, LinearOperator, Preconditioner, SparseRows, Workspace};
use crate::saddle::{BlockStep, MultiplierBlock, SetPoint, Status};

/// Growth of a scale within one program beyond which it is divergence.
const LARGEST_GROWTH: f64 = 1e3;
/// Norm of a constraint or gap that is rounding, non-dimensional.
const ROUNDING: f64 = 1e-13;

/// The problem; shapes as in the equation of [`super::one_level`].
#[derive(Clone, Copy)]
pub struct QpProblem<'a> {
    /// A without `curvature` `[displacement, displacement]`.
    pub stiffness: &'a dyn LinearOperator,
    /// What the multipliers take off A; none where the gap is linear.
    pub curvature: Option<&'a SparseRows>,
    /// Terms that vanish where the constraints of contact hold; none where A is not
    /// indefinite without them. Read by the methods on one level.
    pub augmentation: Option<&'a Augmentation>,
    /// Approximate inverse of A, fixed during the solve.
    pub displacement: &'a dyn Preconditioner,
    /// How multipliers and displacement are stepped by the preconditioner of the whole
    /// system.
    pub step: &'a dyn BlockStep,
    /// The equalities, such as the internal pressure, then one block with a dense
    /// metric: all multipliers of contact, whose sets may differ part by part. It may
    /// be without rows.
    pub blocks: &'a [MultiplierBlock<'a>],
}

/// What a solve may use, and who follows it.
pub struct QpRun<'a, 'b> {
    /// When the problem counts as solved.
    pub targets: QpTargets,
    /// Scales of the blocks that have no load of their own; they grow with the norms
    /// seen.
    pub scales: &'a mut QpScales,
    /// Krylov iterations: of the whole solve on one level, of each inner solve
    /// of a nested method.
    pub iterations: u32,
    /// Kept from earlier problems with the same A and equalities.
    pub directions: &'a mut gcr::Directions,
    /// Called after every Krylov iteration with norms and counts; its answer may stop
    /// the solve.
    pub progress: &'a mut Progress<'b>,
    /// Scratch vectors, handed back after use.
    pub work: &'a mut Workspace,
}

/// Iterate and residuals; on entry the increments are zero.
#[derive(Clone, Debug, Default)]
pub struct QpIterate {
    /// Increment du of the displacement `[displacement]`, non-dimensional.
    pub displacement: Vec<f64>,
    /// f - A du - sum of D^T x `[displacement]`; on entry with the entry's x taken off.
    pub force: Vec<f64>,
    /// One for each block of the problem, in its order.
    pub blocks: Vec<BlockIterate>,
}

/// The multipliers of one block.
#[derive(Clone, Debug, Default)]
pub struct BlockIterate {
    /// x `[block]`; of an equality, its increment will do.
    pub multiplier: Vec<f64>,
    /// g - B du + C dx `[block]`: of contact the gap.
    pub residual: Vec<f64>,
    /// What each multiplier does `[block]`; of an equality it is not read.
    pub status: Vec<Status>,
    /// Points that slip; empty without friction.
    pub slides: Vec<Slide>,
}

/// A point of friction that slips: its traction follows its pressure along one direction,
/// and gives way to slip across it,
///
/// ```text
/// t = a n + b w,   b . s + c w = 0,   c = |s| / |t|
/// ```
///
/// the law linearised about a traction on the edge. w stands in the place of the first of its
/// numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slide {
    /// The pressure that it follows.
    pub leader: u32,
    /// The first number of the traction.
    pub first: u32,
    /// How many numbers the traction has: one or two.
    pub width: u8,
    /// a: change of the traction with the pressure.
    pub along: [f64; 2],
    /// b: the unit vector across the slip; zero where there is one tangent only.
    pub across: [f64; 2],
    /// c: slip over traction.
    pub softness: f64,
}

impl BlockIterate {
    /// Of an equality with that residual, before the first increment.
    pub fn of_equality(residual: Vec<f64>) -> Self {
        Self {
            multiplier: vec![0.0; residual.len()],
            residual,
            status: Vec::new(),
            slides: Vec::new(),
        }
    }

    /// As its set asks for it.
    pub fn point(&self) -> SetPoint<'_> {
        SetPoint {
            multiplier: &self.multiplier,
            residual: &self.residual,
            status: &self.status,
        }
    }

    /// Number of multipliers at work.
    pub fn closed(&self) -> usize {
        self.status.iter().filter(|s| s.is_closed()).count()
    }
}

/// Norms of the residual blocks on the current face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QpNorms {
    /// Norm of the force residual, non-dimensional.
    pub force: f64,
    /// Norm of the residual of the equality constraint, non-dimensional.
    pub constraint: f64,
    /// Norm of the gap on the multipliers that stick, non-dimensional.
    pub gap: f64,
}

/// Scales of the blocks that have no load of their own: the largest norms seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QpScales {
    /// Largest norm of the equality constraint so far, which stands for one.
    pub constraint: f64,
    /// Largest norm of the gap so far, which stands for one.
    pub gap: f64,
}

impl QpScales {
    /// Takes larger norms over.
    pub fn see(&mut self, constraint: f64, gap: f64) {
        self.constraint = self.constraint.max(constraint);
        self.gap = self.gap.max(gap);
    }

    /// These scales, and those of `seen` where these have seen nothing yet.
    pub fn or(self, seen: Self) -> Self {
        let known = |scale: f64, seen: f64| if scale > 0.0 { scale } else { seen };
        Self {
            constraint: known(self.constraint, seen.constraint),
            gap: known(self.gap, seen.gap),
        }
    }

    /// The largest scales that iterations from here may show: what exceeds them is no motion of
    /// the body but a method that diverges, beside which any state would be a solution. A scale
    /// of rounding has seen nothing yet.
    pub fn largest_to_come(&self) -> Self {
        let bound = |scale: f64| {
            if scale > ROUNDING {
                LARGEST_GROWTH * scale
            } else {
                f64::INFINITY
            }
        };
        Self {
            constraint: bound(self.constraint),
            gap: bound(self.gap),
        }
    }
}

/// When the problem counts as solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QpTargets {
    /// Norm of the force that counts as one: that of the load.
    pub force_scale: f64,
    /// Bound on all norms over their scales, at which the problem counts as solved.
    pub level: f64,
    /// Error of the multipliers that the next problem bears, in their own unit; none
    /// where their relative error is all that counts.
    pub multiplier_error: Option<f64>,
}

impl QpTargets {
    /// The level that a solution with multipliers up to `largest` asks for.
    pub(crate) fn level_for(&self, largest: f64) -> f64 {
        match self.multiplier_error {
            Some(error) if error < self.level * largest => error / largest,
            Some(_) | None => self.level,
        }
    }
}

impl QpNorms {
    /// The largest norm over its scale; not a number if a norm is not.
    pub fn relative(&self, force_scale: f64, scales: &QpScales) -> f64 {
        worst(&[
            ratio(self.force, force_scale),
            ratio(self.constraint, scales.constraint),
            ratio(self.gap, scales.gap),
        ])
    }
}

/// Why the solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QpStatus {
    /// The targets were reached on the right set.
    Solved,
    /// The caller asked to stop; the iterate is the best so far.
    Interrupted,
    /// The set returned to an earlier one at full accuracy.
    ActiveSetCycle,
    /// The compliance is not positive definite on some face, so that no multiplier is
    /// determined by it.
    IndefiniteMetric,
    /// The factor of the problem takes more work or memory than it may.
    TooLarge,
    /// The method does not take such blocks or sets; the plan asks for none of these
    /// combinations.
    Unsupported,
    /// The Krylov method failed in the way that its outcome tells.
    Krylov(Outcome),
}

impl From<FactoriseError> for QpStatus {
    fn from(error: FactoriseError) -> Self {
        match error {
            FactoriseError::OutOfMemory => Self::TooLarge,
            FactoriseError::NotPositiveDefinite => Self::IndefiniteMetric,
        }
    }
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
    /// Why the solve ended.
    pub status: QpStatus,
    /// Krylov iterations, one displacement preconditioner application each.
    pub iterations: u32,
    /// Preconditioner applications outside the Krylov iterations.
    pub predictions: u32,
    /// Products with B S^-1 D^T, one inner solve each; none on one level.
    pub products: u32,
    /// How often the statuses were revised after the first set.
    pub set_changes: u32,
    /// Steps of Newton's method for friction in the dense problems of the faces.
    pub newton_steps: u32,
    /// Passes of the iteration on the threshold of friction.
    pub threshold_passes: u32,
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
            newton_steps: 0,
            threshold_passes: 0,
        }
    }

    /// Adds what another one has counted; the status stays.
    pub fn add(&mut self, other: &Self) {
        self.iterations += other.iterations;
        self.predictions += other.predictions;
        self.products += other.products;
        self.set_changes += other.set_changes;
        self.newton_steps += other.newton_steps;
        self.threshold_passes += other.threshold_passes;
    }
}

/// Sees every iteration; returns whether to go on.
pub type Progress<'a> = dyn FnMut(&QpNorms, &QpScales, usize) -> Verdict + 'a;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_norm_that_is_not_a_number_never_counts_as_small() {
        let scales = QpScales {
            constraint: 1.0,
            gap: 1.0,
        };
        for place in 0..3 {
            let mut norms = [1e-20; 3];
            norms[place] = f64::NAN;
            let [force, constraint, gap] = norms;
            let norms = QpNorms {
                force,
                constraint,
                gap,
            };
            assert!(norms.relative(1.0, &scales).is_nan(), "{place}");
        }
        let zero = QpNorms::default().relative(0.0, &QpScales::default());
        assert!(zero.abs() < f64::MIN_POSITIVE);
    }
}
