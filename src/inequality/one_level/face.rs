//! One face of the admissible set: operators restricted to the active
//! multipliers, their metric, and the monitor of its Krylov iterations.

use super::super::qp::{Progress, QpNorms, QpScales, QpStatus, QpTargets};
use super::{GAP_WEIGHT, REVIEW};
use crate::krylov::{Monitor, Verdict};
use crate::linalg::vector::{norm, scale};
use crate::linalg::{
    DenseCholesky, DenseMatrix, FactoriseError, LinearOperator, Preconditioner, SparseRows,
    Workspace,
};

/// When the active set is reviewed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Review {
    WhenReduced,
    AtTheEnd,
}

pub(super) struct Face {
    pub(super) iterations: u32,
    pub(super) reached: bool,
    pub(super) failed: Option<QpStatus>,
}

/// Rows of the coupling that belong to the active set, weighted.
pub(super) struct ActiveCoupling<'a> {
    pub(super) coupling: &'a SparseRows,
    pub(super) active: &'a [bool],
}

impl LinearOperator for ActiveCoupling<'_> {
    fn rows(&self) -> usize {
        self.coupling.rows()
    }

    fn columns(&self) -> usize {
        self.coupling.columns()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.coupling.apply(x, y, work);
        for (value, &active) in y.iter_mut().zip(self.active) {
            *value *= if active { GAP_WEIGHT } else { 0.0 };
        }
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.coupling.apply_transposed(y, x, work);
        scale(x, GAP_WEIGHT);
    }

    fn add_transposed(&self, factor: f64, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.coupling
            .add_transposed(factor * GAP_WEIGHT, y, x, work);
    }
}

/// The weighted compliance's inverse on the active set.
pub(super) struct ActiveMetric {
    pub(super) selected: Vec<usize>,
    pub(super) factor: DenseCholesky,
}

impl ActiveMetric {
    pub(super) fn new(compliance: &DenseMatrix, active: &[bool]) -> Result<Self, FactoriseError> {
        let selected: Vec<usize> = (0..active.len()).filter(|&i| active[i]).collect();
        let factor = DenseCholesky::new(&compliance.principal(&selected))?;
        Ok(Self { selected, factor })
    }
}

impl Preconditioner for ActiveMetric {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let mut small = work.scratch(self.selected.len());
        for (value, &index) in small.iter_mut().zip(&self.selected) {
            *value = r[index];
        }
        self.factor.solve(&mut small);
        z.fill(0.0);
        for (value, &index) in small.iter().zip(&self.selected) {
            z[index] = *value / (GAP_WEIGHT * GAP_WEIGHT);
        }
        work.give(small);
    }
}

pub(super) struct FaceMonitor<'a, 'b> {
    pub(super) displacement: usize,
    pub(super) equality: usize,
    pub(super) targets: QpTargets,
    pub(super) scales: &'a mut QpScales,
    pub(super) review: Review,
    /// Relative residual at the start of the face.
    pub(super) start: f64,
    pub(super) iterations: u32,
    pub(super) reached: bool,
    pub(super) interrupted: bool,
    pub(super) active: usize,
    pub(super) progress: &'a mut Progress<'b>,
}

impl FaceMonitor<'_, '_> {
    /// Block norms and the largest over its scale.
    pub(super) fn measure(&mut self, r: &[f64]) -> (QpNorms, f64) {
        let (force, rest) = r.split_at(self.displacement);
        let (constraint, gap) = rest.split_at(self.equality);
        let norms = QpNorms {
            force: norm(force),
            constraint: norm(constraint),
            gap: norm(gap) / GAP_WEIGHT,
        };
        self.scales.see(norms.constraint, norms.gap);
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
        let review = self.review == Review::WhenReduced && relative <= REVIEW * self.start;
        match self.reached || review {
            true => Verdict::Stop,
            false => Verdict::Continue,
        }
    }
}
