//! The problem condensed on the multiplier:
//!
//! ```text
//! min 1/2 l^T K l + q^T l,  l >= 0,   K = C S^-1 C^T,   gap(l) = q + K l,
//! ```
//!
//! S the saddle operator of displacement and equality blocks. K is never made:
//! a product is one inner solve by the GCR of the problem without contact, which
//! starts from the directions that earlier solves kept. All residuals are carried
//! along, so that the iterate is judged as it is, whatever the inner accuracy.

mod inner;

use super::qp::{QpIterate, QpNorms, QpOutcome, QpProblem, QpRun, QpStatus};
use crate::krylov::{Outcome, gcr};
use crate::linalg::LinearOperator;
use crate::linalg::vector::{add_scaled, largest, norm};
use crate::saddle::SaddleOperator;
use inner::{Bounds, InnerMonitor};

/// Accuracy of an inner solve against the target of the outer one: at a tenth,
/// conjugate directions lose each other and take five times the products.
const INNER: f64 = 0.01;
/// Loosest and tightest relative accuracy of a product: the nearer the outer
/// residual is to its target, the less a product needs.
const ACCURACIES: [f64; 2] = [1e-12, 1e-4];

/// Reduction by kept directions beyond which there is nothing new beside them.
const EXHAUSTED: f64 = 1e-8;
/// Growth of the gap that no step within l >= 0 explains.
const DIVERGED: f64 = 1e6;
/// Negative multipliers this small against the largest are rounding.
const ROUNDING: f64 = 1e-14;

/// What a unit step along a change of the multiplier does.
pub(super) struct Response {
    /// The change d.
    pub(super) direction: Vec<f64>,
    /// K d.
    pub(super) opening: Vec<f64>,
    /// Displacement, then equality unknowns.
    unknowns: Vec<f64>,
    /// Change of the force residual, then of the constraint.
    residual: Vec<f64>,
    /// Largest constraint residual on the way.
    peak: f64,
}

/// A problem under way.
pub(super) struct Condensed<'c, 'a, 'b> {
    problem: &'c QpProblem<'c>,
    run: &'c mut QpRun<'a, 'b>,
    outcome: QpOutcome,
    most_products: u32,
    norms: QpNorms,
    active: usize,
    relative: f64,
    /// Norm of the gap when the first inner solve was done.
    first_gap: f64,
}

impl<'c, 'a, 'b> Condensed<'c, 'a, 'b> {
    /// Settles `iterate` under its multiplier and takes steps until it is solved, a
    /// step fails or the products are spent.
    pub(super) fn solve(
        problem: &'c QpProblem<'c>,
        run: &'c mut QpRun<'a, 'b>,
        most_products: u32,
        iterate: &mut QpIterate,
        mut step: impl FnMut(&mut QpIterate, &mut Self) -> Result<(), QpStatus>,
    ) -> QpOutcome {
        let mut condensed = match Self::start(problem, run, most_products, iterate) {
            Ok(condensed) => condensed,
            Err(outcome) => return outcome,
        };
        let status = loop {
            if let Some(status) = condensed.ended(iterate) {
                break status;
            }
            if let Err(failed) = step(iterate, &mut condensed) {
                break failed;
            }
        };
        condensed.finish(status)
    }

    /// Starts at `iterate`, settled under its multiplier.
    ///
    /// # Errors
    /// Why the first inner solve failed, with the counts.
    fn start(
        problem: &'c QpProblem<'c>,
        run: &'c mut QpRun<'a, 'b>,
        most_products: u32,
        iterate: &mut QpIterate,
    ) -> Result<Self, QpOutcome> {
        let mut condensed = Self {
            problem,
            run,
            outcome: QpOutcome::new(QpStatus::Krylov(Outcome::IterationLimit)),
            most_products,
            norms: QpNorms::default(),
            active: 0,
            relative: 1.0,
            first_gap: 0.0,
        };
        // Products with another curvature are of another operator.
        condensed.forget_curved();
        condensed.measure(iterate);
        match condensed.settle(iterate) {
            Ok(()) => {
                condensed.measure(iterate);
                condensed.first_gap = condensed.norms.gap;
                Ok(condensed)
            }
            Err(status) => Err(condensed.finish(status)),
        }
    }

    /// The outcome.
    fn finish(mut self, status: QpStatus) -> QpOutcome {
        self.forget_curved();
        self.outcome.status = status;
        self.outcome
    }

    fn forget_curved(&mut self) {
        if self.problem.curvature.is_some() {
            self.run.directions.clear(self.run.work);
        }
    }

    /// Measures the iterate; tells how to end when it is solved or the products
    /// are spent.
    fn ended(&mut self, iterate: &mut QpIterate) -> Option<QpStatus> {
        self.measure(iterate);
        if !(self.relative + self.run.scales.gap).is_finite() {
            return Some(QpStatus::Krylov(Outcome::NotFinite));
        }
        if self.relative <= self.run.targets.level {
            return Some(QpStatus::Solved);
        }
        if self.norms.gap > DIVERGED * self.first_gap {
            return Some(QpStatus::Krylov(Outcome::Stagnation));
        }
        (self.outcome.products >= self.most_products)
            .then_some(QpStatus::Krylov(Outcome::IterationLimit))
    }

    fn measure(&mut self, iterate: &mut QpIterate) {
        let active: Vec<bool> = iterate.multiplier.iter().map(|&l| l > 0.0).collect();
        self.outcome.set_changes += u32::from(active != iterate.active);
        self.active = active.iter().filter(|&&a| a).count();
        iterate.active = active;
        let wrong = |(g, &active): (&f64, &bool)| if active { *g } else { g.min(0.0) };
        let gaps: Vec<f64> = iterate.gap.iter().zip(&iterate.active).map(wrong).collect();
        self.norms = QpNorms {
            force: norm(&iterate.force),
            constraint: norm(&iterate.constraint),
            gap: norm(&gaps),
        };
        let scales = &mut *self.run.scales;
        scales.see(self.norms.constraint, self.norms.gap);
        self.relative = self.norms.relative(self.run.targets.force_scale, scales);
    }

    /// Brings displacement and equality unknowns to balance with the multiplier.
    ///
    /// # Errors
    /// Why the inner solve failed.
    fn settle(&mut self, iterate: &mut QpIterate) -> Result<(), QpStatus> {
        let level = INNER * self.run.targets.level;
        let bounds = Bounds {
            force: level * self.run.targets.force_scale,
            constraint: level,
        };
        let mut r = self.run.work.copy(&iterate.force);
        r.extend_from_slice(&iterate.constraint);
        let known = self.run.scales.constraint;
        let (x, peak) = self.inner(&mut r, bounds, known)?;
        self.run.scales.see(peak, 0.0);
        let unknowns = iterate.force.len();
        let mut opening = vec![0.0; iterate.gap.len()];
        self.opening(&x, &mut opening);
        add_scaled(&mut iterate.displacement, 1.0, &x[..unknowns]);
        add_scaled(&mut iterate.equality, 1.0, &x[unknowns..]);
        add_scaled(&mut iterate.gap, 1.0, &opening);
        iterate.force.copy_from_slice(&r[..unknowns]);
        iterate.constraint.copy_from_slice(&r[unknowns..]);
        self.run.work.give(x);
        self.run.work.give(r);
        Ok(())
    }

    /// The response to a change of the multiplier.
    ///
    /// # Errors
    /// Why the inner solve failed.
    pub(super) fn product(&mut self, direction: Vec<f64>) -> Result<Response, QpStatus> {
        let [least, most] = ACCURACIES;
        let accuracy = (INNER * self.run.targets.level / self.relative).clamp(least, most);
        let unknowns = self.problem.stiffness.rows();
        let mut load = self.run.work.zeros(unknowns);
        let coupling = self.problem.coupling;
        coupling.apply_transposed(&direction, &mut load, self.run.work);
        load.iter_mut().for_each(|value| *value = -*value);
        let bounds = Bounds {
            force: accuracy * norm(&load),
            constraint: accuracy,
        };
        load.resize(unknowns + self.equalities(), 0.0);
        let (x, peak) = self.inner(&mut load, bounds, 0.0)?;
        let mut opening = vec![0.0; direction.len()];
        self.opening(&x, &mut opening);
        Ok(Response {
            direction,
            opening,
            unknowns: x,
            residual: load,
            peak,
        })
    }

    /// Moves `iterate` along a response.
    pub(super) fn advance(&mut self, iterate: &mut QpIterate, response: Response, length: f64) {
        let unknowns = iterate.force.len();
        let (du, dx) = response.unknowns.split_at(unknowns);
        let (force, constraint) = response.residual.split_at(unknowns);
        add_scaled(&mut iterate.displacement, length, du);
        add_scaled(&mut iterate.equality, length, dx);
        let pairs = iterate.multiplier.iter_mut().zip(&response.direction);
        for (l, d) in pairs {
            let change = length * d;
            *l += change;
            // What leaves the set leaves it whole.
            if change < 0.0 && l.abs() <= 4.0 * f64::EPSILON * change.abs() {
                *l = 0.0;
            }
        }
        add_scaled(&mut iterate.force, length, force);
        add_scaled(&mut iterate.constraint, length, constraint);
        add_scaled(&mut iterate.gap, length, &response.opening);
        self.run.scales.see(length.abs() * response.peak, 0.0);
        self.run.work.give(response.unknowns);
        self.run.work.give(response.residual);
    }

    /// Changes the multiplier and settles: one product.
    ///
    /// # Errors
    /// Why the inner solve failed.
    pub(super) fn shift(
        &mut self,
        iterate: &mut QpIterate,
        change: &[f64],
    ) -> Result<(), QpStatus> {
        let mut load = self.run.work.zeros(iterate.force.len());
        let coupling = self.problem.coupling;
        coupling.apply_transposed(change, &mut load, self.run.work);
        add_scaled(&mut iterate.force, -1.0, &load);
        self.run.work.give(load);
        add_scaled(&mut iterate.multiplier, 1.0, change);
        self.settle(iterate)
    }

    /// Projects negative multipliers to zero; one product where there are any.
    /// Returns whether there were.
    ///
    /// # Errors
    /// Why the inner solve failed.
    pub(super) fn clip(&mut self, iterate: &mut QpIterate) -> Result<bool, QpStatus> {
        let excess: Vec<f64> = iterate.multiplier.iter().map(|l| (-l).max(0.0)).collect();
        let counts = largest(&excess) > ROUNDING * largest(&iterate.multiplier);
        if counts {
            self.shift(iterate, &excess)?;
        }
        iterate.multiplier.iter_mut().for_each(|l| *l = l.max(0.0));
        Ok(counts)
    }

    fn equalities(&self) -> usize {
        let blocks = self.problem.equality.iter();
        blocks.map(|block| block.coupling.rows()).sum()
    }

    /// -C du of packed unknowns.
    fn opening(&mut self, x: &[f64], opening: &mut [f64]) {
        let u = &x[..self.problem.stiffness.rows()];
        self.problem.coupling.apply(u, opening, self.run.work);
        opening.iter_mut().for_each(|value| *value = -*value);
    }

    /// Solves S x = r to the bounds; `r` becomes the residual. Also the largest
    /// constraint residual, at least `known`.
    fn inner(
        &mut self,
        r: &mut [f64],
        bounds: Bounds,
        known: f64,
    ) -> Result<(Vec<f64>, f64), QpStatus> {
        let problem = self.problem;
        let mut x = self.run.work.zeros(r.len());
        let mut monitor = InnerMonitor {
            displacement: problem.stiffness.rows(),
            bounds,
            peak: known,
            iterations: 0,
            reached: false,
            interrupted: false,
            outer: self.norms,
            active: self.active,
            scales: *self.run.scales,
            progress: self.run.progress,
        };
        if monitor.measure(r) {
            return Ok((x, monitor.peak));
        }
        // What earlier solves know may be all that this one needs.
        self.outcome.products += 1;
        let before = norm(r);
        self.run.directions.project(&mut x, r);
        if monitor.measure(r) {
            return Ok((x, monitor.peak));
        }
        if norm(r) < EXHAUSTED * before {
            // New directions would differ from the kept ones by rounding.
            self.run.directions.clear(self.run.work);
        }
        let released = problem.curvature.map(|c| c as &dyn LinearOperator);
        let blocks = problem.equality;
        let displacement = problem.displacement;
        let outcome = gcr::solve(
            &SaddleOperator {
                stiffness: problem.stiffness,
                released,
                blocks,
            },
            &*problem
                .step
                .preconditioner(problem.stiffness, displacement, blocks),
            &mut x,
            r,
            self.run.iterations as usize,
            self.run.directions,
            &mut monitor,
            self.run.work,
        );
        self.outcome.iterations += monitor.iterations;
        let failed = match monitor.interrupted {
            true => Some(QpStatus::Interrupted),
            false => QpStatus::failure(outcome),
        };
        failed.map_or(Ok((x, monitor.peak)), Err)
    }
}
