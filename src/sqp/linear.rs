//! Programs without contact by methods that know no inequality, followed, counted and
//! stopped.
//!
//! Unknowns (du, dx) and residuals are those of the quadratic program.

use std::sync::atomic::{AtomicU32, Ordering};

use crate::inequality::{
    LinearSolver, LinearSystem, QpIterate, QpNorms, QpOutcome, QpScales, QpStatus, QpTargets,
};
use crate::krylov::{Monitor, Verdict};
use crate::linalg::Workspace;
use crate::linalg::vector::norm;
use crate::model::counters::Counters;
use crate::precond::Counted;
use crate::sqp::watch::Watch;

/// Counts, reports and stops the iterations of one program.
pub(crate) struct Track<'a, 'w> {
    /// Who follows the increment, and what stops it.
    pub(crate) watch: &'a mut Watch<'w>,
    /// Counts of the increment, which the iterations add to.
    pub(crate) counters: &'a mut Counters,
    /// Approximate inverse of A, which counts its own applications.
    pub(crate) displacement: &'a Counted<'a>,
    /// Solutions with a factor of the body, which count as applications; none without one.
    pub(crate) solutions: Option<&'a AtomicU32>,
    /// Number of applications before this program, so that they are not counted twice.
    pub(crate) before: u32,
    /// When the program counts as solved.
    pub(crate) targets: QpTargets,
}

impl Track<'_, '_> {
    /// One iteration; says whether to go on.
    pub(crate) fn iteration(
        &mut self,
        norms: &QpNorms,
        scales: &QpScales,
        active: usize,
    ) -> Verdict {
        self.counters.krylov_iterations += 1;
        self.count();
        let force_scale = self.targets.force_scale;
        self.watch
            .report(norms, scales, force_scale, active, self.counters);
        self.poll()
    }

    /// Takes over the applications so far.
    pub(crate) fn count(&mut self) {
        let solutions = self
            .solutions
            .map_or(0, |count| count.load(Ordering::Relaxed));
        self.counters.applications = self.before + self.displacement.applications() + solutions;
    }

    /// Stops where the caller, a deadline or the wall limit asks for it.
    pub(crate) fn poll(&self) -> Verdict {
        match self.watch.stopped(self.counters) {
            Some(_) => Verdict::Stop,
            None => Verdict::Continue,
        }
    }
}

/// A linear system and the method for it.
pub(crate) struct Linear<'a> {
    /// The method for the system.
    pub(crate) method: &'a dyn LinearSolver,
    /// The system.
    pub(crate) system: LinearSystem<'a>,
}

impl Linear<'_> {
    /// Improves `iterate` until the targets are reached.
    pub(crate) fn solve(
        &self,
        iterate: &mut QpIterate,
        scales: &mut QpScales,
        track: &mut Track<'_, '_>,
        work: &mut Workspace,
    ) -> QpOutcome {
        let unknowns = iterate.force.len();
        let mut monitor = LinearMonitor {
            displacement: unknowns,
            targets: self.system.targets,
            scales,
            track,
            iterations: 0,
            reached: false,
        };
        let mut x = std::mem::take(&mut iterate.displacement);
        let mut r = std::mem::take(&mut iterate.force);
        // Where there is a pressure, its block is the first.
        let mut pressure = self
            .system
            .pressure
            .and_then(|_| iterate.blocks.first_mut());
        if let Some(block) = &pressure {
            x.extend_from_slice(&block.multiplier);
            r.extend_from_slice(&block.residual);
        }
        let outcome = self
            .method
            .solve(&self.system, (&mut x, &mut r), &mut monitor, work);
        if let Some(block) = &mut pressure {
            block.multiplier = x.split_off(unknowns);
            block.residual = r.split_off(unknowns);
        }
        iterate.displacement = x;
        iterate.force = r;
        let stopped = if monitor.reached {
            QpStatus::Solved
        } else {
            QpStatus::Interrupted
        };
        QpOutcome {
            iterations: monitor.iterations,
            ..QpOutcome::new(QpStatus::failure(outcome).unwrap_or(stopped))
        }
    }
}

/// Follows the iterations of a linear system: norms, targets, reports.
struct LinearMonitor<'a, 'b, 'w> {
    /// Number of displacement unknowns, which come first in the residual.
    displacement: usize,
    /// When the system counts as solved.
    targets: QpTargets,
    /// Scales of the blocks without a load of their own; they grow with the norms seen.
    scales: &'a mut QpScales,
    /// Counts, reports and stops.
    track: &'a mut Track<'b, 'w>,
    /// Number of iterations so far.
    iterations: u32,
    /// Whether the targets were reached.
    reached: bool,
}

impl Monitor for LinearMonitor<'_, '_, '_> {
    fn judge(&mut self, residual: &[f64]) -> Verdict {
        self.iterations += 1;
        let (force, constraint) = residual.split_at(self.displacement);
        let norms = QpNorms {
            force: norm(force),
            constraint: norm(constraint),
            gap: 0.0,
        };
        self.scales.see(norms.constraint, norms.gap);
        self.reached = norms.relative(self.targets.force_scale, self.scales) <= self.targets.level;
        match self.track.iteration(&norms, self.scales, 0) {
            Verdict::Continue if !self.reached => Verdict::Continue,
            Verdict::Continue | Verdict::Stop => Verdict::Stop,
        }
    }

    fn poll(&mut self) -> Verdict {
        self.track.poll()
    }
}
