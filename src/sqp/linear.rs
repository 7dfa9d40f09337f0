//! Programs without contact by the methods that know no inequality: conjugate
//! gradients and the stationary iteration on the displacement, MINRES and nested
//! Uzawa on displacement and pressure.
//!
//! Unknowns (du, dx) and residuals are those of the quadratic program.

use super::counters::Counters;
use super::watch::Watch;
use crate::inequality::{QpIterate, QpNorms, QpOutcome, QpScales, QpStatus, QpTargets};
use crate::krylov::{Monitor, Outcome, Verdict, cg, minres, stationary};
use crate::linalg::vector::norm;
use crate::linalg::{LinearOperator, Preconditioner, Workspace};
use crate::plan::SaddleMethod;
use crate::precond::Counted;
use crate::saddle::{BlockDiagonal, MultiplierBlock, SaddleOperator, Uzawa};

/// Share of the force target that one inner solve of Uzawa may leave.
const INNER_SHARE: f64 = 0.1;

/// Counts, reports and stops the iterations of one program.
pub(super) struct Track<'a, 'w> {
    pub(super) watch: &'a mut Watch<'w>,
    pub(super) counters: &'a mut Counters,
    pub(super) displacement: &'a Counted<'a>,
    /// Applications before this program.
    pub(super) before: u32,
    pub(super) force_scale: f64,
}

impl Track<'_, '_> {
    /// One iteration; says whether to go on.
    pub(super) fn iteration(
        &mut self,
        norms: &QpNorms,
        scales: &QpScales,
        active: usize,
    ) -> Verdict {
        self.counters.krylov_iterations += 1;
        self.count();
        self.watch
            .report(norms, scales, self.force_scale, active, self.counters);
        self.poll()
    }

    /// Takes over the applications so far.
    pub(super) fn count(&mut self) {
        self.counters.applications = self.before + self.displacement.applications();
    }

    fn poll(&self) -> Verdict {
        match self.watch.stopped(self.counters) {
            Some(_) => Verdict::Stop,
            None => Verdict::Continue,
        }
    }
}

/// A linear system and the method for it.
pub(super) struct Linear<'a> {
    pub(super) method: SaddleMethod,
    pub(super) stiffness: &'a dyn LinearOperator,
    pub(super) displacement: &'a dyn Preconditioner,
    /// The internal pressure, or none.
    pub(super) blocks: &'a [MultiplierBlock<'a>],
    pub(super) iterations: usize,
}

impl Linear<'_> {
    /// Improves `iterate` until the targets are reached.
    pub(super) fn solve(
        &self,
        iterate: &mut QpIterate,
        targets: &QpTargets,
        scales: &mut QpScales,
        track: &mut Track<'_, '_>,
        work: &mut Workspace,
    ) -> QpOutcome {
        let unknowns = iterate.force.len();
        let mut monitor = LinearMonitor {
            displacement: unknowns,
            targets: *targets,
            scales,
            track,
            iterations: 0,
            reached: false,
        };
        let mut x = std::mem::take(&mut iterate.displacement);
        x.extend_from_slice(&iterate.equality);
        let mut r = std::mem::take(&mut iterate.force);
        r.extend_from_slice(&iterate.constraint);
        let outcome = self.run(&mut x, &mut r, &mut monitor, work);
        iterate.equality = x.split_off(unknowns);
        iterate.displacement = x;
        iterate.constraint = r.split_off(unknowns);
        iterate.force = r;
        let stopped = match monitor.reached {
            true => QpStatus::Solved,
            false => QpStatus::Interrupted,
        };
        QpOutcome {
            iterations: monitor.iterations,
            ..QpOutcome::new(QpStatus::failure(outcome).unwrap_or(stopped))
        }
    }

    fn run(
        &self,
        x: &mut [f64],
        r: &mut [f64],
        monitor: &mut LinearMonitor<'_, '_, '_>,
        work: &mut Workspace,
    ) -> Outcome {
        let (a, approximate) = (self.stiffness, self.displacement);
        let inner_bound = INNER_SHARE * monitor.targets.level * monitor.targets.force_scale;
        match (self.method, self.blocks) {
            (SaddleMethod::Stationary, _) => {
                stationary::solve(a, approximate, x, r, self.iterations, monitor, work)
            }
            (SaddleMethod::UzawaCg, [block]) => Uzawa {
                stiffness: a,
                displacement: approximate,
                block: *block,
                inner_bound,
            }
            .solve(x, r, self.iterations, monitor, work),
            (SaddleMethod::Minres, blocks) => {
                let system = SaddleOperator {
                    stiffness: a,
                    released: None,
                    blocks,
                };
                let diagonal = BlockDiagonal {
                    displacement: approximate,
                    blocks,
                };
                minres::solve(&system, &diagonal, x, r, self.iterations, monitor, work)
            }
            (
                SaddleMethod::ConjugateGradients
                | SaddleMethod::UzawaCg
                | SaddleMethod::Gcr
                | SaddleMethod::ArrowHurwicz,
                _,
            ) => cg::solve(a, approximate, x, r, self.iterations, monitor, work),
        }
    }
}

struct LinearMonitor<'a, 'b, 'w> {
    displacement: usize,
    targets: QpTargets,
    scales: &'a mut QpScales,
    track: &'a mut Track<'b, 'w>,
    iterations: u32,
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
