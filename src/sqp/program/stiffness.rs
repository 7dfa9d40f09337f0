//! The stiffness that a program leaves to small motions, and its inverse:
//!
//! ```text
//! K = A - (what loads and the curvature of the gaps take off),   B x = 0,   C_active x = 0
//! ```
//!
//! One inversion costs what one program on a fixed active set costs.

use super::super::counters::Counters;
use super::super::stability::Accuracy;
use super::super::state::State;
use super::super::watch::Watch;
use super::Program;
use crate::inequality::{OneLevel, QpIterate, QpNorms, QpRun, QpScales, QpStatus, QpTargets};
use crate::krylov::Verdict;
use crate::linalg::vector::{dot, norm};
use crate::linalg::{LinearOperator, SparseRows, Workspace};
use crate::precond::Counted;

impl Program<'_> {
    /// K^-1 `force` among the motions that volume and the present
    /// contacts admit; none where it was stopped.
    pub(in crate::sqp) fn invert(
        &self,
        state: &mut State,
        force: Vec<f64>,
        accuracy: Accuracy,
        watch: &Watch<'_>,
        counters: &mut Counters,
        work: &mut Workspace,
    ) -> Option<Vec<f64>> {
        let mut iterate = QpIterate {
            displacement: vec![0.0; force.len()],
            equality: vec![0.0; state.pressure.len()],
            multiplier: vec![0.0; state.multiplier.len()],
            constraint: vec![0.0; state.pressure.len()],
            gap: vec![0.0; state.multiplier.len()],
            active: state.active.clone(),
            force,
        };
        let targets = QpTargets {
            force_scale: norm(&iterate.force),
            level: accuracy.level,
        };
        let displacement = Counted::new(&*self.inverse.displacement);
        let blocks = self.blocks();
        let problem = self.problem(self.taken_off(), &displacement, &blocks, work);
        let mut progress = |_: &QpNorms, _: &QpScales, _: usize| match watch.stopped(counters) {
            Some(_) => Verdict::Stop,
            None => Verdict::Continue,
        };
        state.directions.clear(work);
        let mut run = QpRun {
            targets,
            scales: &mut QpScales::default(),
            iterations: accuracy.iterations,
            directions: &mut state.directions,
            progress: &mut progress,
            work,
        };
        let status = OneLevel::new(problem).solve_on_face(&mut iterate, &mut run);
        counters.eigenvalue_applications += displacement.applications();
        match status {
            Some(QpStatus::Interrupted | QpStatus::IndefiniteMetric) => None,
            _ => Some(iterate.displacement),
        }
    }

    /// x.(A - what is taken off) x.
    pub(in crate::sqp) fn curvature_along(&self, x: &[f64], work: &mut Workspace) -> f64 {
        let stiff = along(self.stiffness(), x, work);
        match self.taken_off() {
            Some(taken_off) => stiff - along(taken_off, x, work),
            None => stiff,
        }
    }

    pub(super) fn has_positive_stiffness(
        &self,
        curvature: &SparseRows,
        step: &[f64],
        work: &mut Workspace,
    ) -> bool {
        along(self.stiffness(), step, work) >= along(curvature, step, work)
    }
}

/// x.M x.
fn along(matrix: &dyn LinearOperator, x: &[f64], work: &mut Workspace) -> f64 {
    let mut product = work.scratch(x.len());
    matrix.apply(x, &mut product, work);
    let sum = dot(x, &product);
    work.give(product);
    sum
}
