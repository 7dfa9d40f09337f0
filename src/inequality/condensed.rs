//! The problem condensed on the multiplier:
//!
//! ```text
//! min 1/2 l^T K l + q^T l,  l in its set,   K = C S^-1 C^T,   gap(l) = q + K l,
//! ```
//!
//! S the saddle operator of displacement and equalities. K is never made:
//! a product is one inner solve by the GCR of the problem without contact, which
//! starts from the directions that earlier solves kept. All residuals are carried
//! along, so that the iterate is judged as it is, whatever the inner accuracy.

mod inner;

use super::blocks::{Blocks, ContactBlock};
use super::qp::{QpIterate, QpNorms, QpOutcome, QpProblem, QpRun, QpStatus};
use crate::krylov::Outcome;
use crate::krylov::gcr::Gcr;
use crate::linalg::LinearOperator;
use crate::linalg::vector::{add_scaled, norm};
use crate::saddle::{EqualityBlock, SaddleOperator};
use inner::{Bounds, InnerMonitor};

/// Accuracy of an inner solve against the target of the outer one: at a tenth,
/// conjugate directions lose each other and take five times the products.
const INNER: f64 = 0.01;
/// Loosest and tightest relative accuracy of a product: the nearer the outer
/// residual is to its target, the less a product needs.
const ACCURACIES: [f64; 2] = [1e-12, 1e-4];

/// Reduction by kept directions beyond which there is nothing new beside them.
const EXHAUSTED: f64 = 1e-8;
/// Growth of the gap that no step within the set explains.
const DIVERGED: f64 = 1e6;

/// What a unit step along a change of the multiplier does.
pub struct Response {
    /// The change d of the multiplier `[multipliers]`.
    pub direction: Vec<f64>,
    /// K d, by how much the gap opens along d `[multipliers]`.
    pub opening: Vec<f64>,
    /// Change of the displacement and of the equality unknowns, one after the other.
    unknowns: Vec<f64>,
    /// Change of the force residual, then of the constraint.
    residual: Vec<f64>,
    /// Largest norm of the constraint residual on the way, which bounds what rounding
    /// may leave of it.
    peak: f64,
}

/// A problem under way.
pub struct Condensed<'c, 'a, 'b> {
    /// The whole problem with all its blocks.
    problem: &'c QpProblem<'c>,
    /// Equalities and contact of the problem, told apart.
    blocks: Blocks<'c>,
    /// What the solve may use, and who follows it.
    run: &'c mut QpRun<'a, 'b>,
    /// Counts so far; its status is set at the end.
    outcome: QpOutcome,
    /// Products with the exact compliance at most; beyond them the method has failed.
    most_products: u32,
    /// Norms of the residual blocks at the iterate last measured.
    norms: QpNorms,
    /// Number of closed multipliers at the iterate last measured.
    active: usize,
    /// Largest of the norms over their scales, which the inner tolerance follows.
    relative: f64,
    /// Norm of the gap when the first inner solve was done.
    first_gap: f64,
}

impl<'c, 'a, 'b> Condensed<'c, 'a, 'b> {
    /// Settles `iterate` under its multiplier and takes steps until it is solved, a
    /// step fails or the products are spent.
    pub fn solve(
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
        let blocks = Blocks::of(problem, iterate).map_err(QpOutcome::new)?;
        let mut condensed = Self {
            problem,
            blocks,
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

    /// Drops stored Krylov directions where the problem has curvature: their products
    /// would be those of another operator.
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

    /// Takes statuses, norms and scales of the iterate; a change of any status counts
    /// as one change of the set.
    fn measure(&mut self, iterate: &mut QpIterate) {
        let (equalities, contact) = iterate.blocks.split_at_mut(self.blocks.place());
        let contact = &mut contact[0];
        let set = self.blocks.contact.set;
        let status = set.status(&contact.multiplier);
        self.outcome.set_changes += u32::from(status != contact.status);
        contact.status = status;
        self.active = contact.closed();
        let constraints = equalities.iter().map(|block| norm(&block.residual));
        self.norms = QpNorms {
            force: norm(&iterate.force),
            constraint: constraints.fold(0.0, f64::hypot),
            gap: norm(&set.misfit(contact.point())),
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
        let place = self.blocks.place();
        for block in &iterate.blocks[..place] {
            r.extend_from_slice(&block.residual);
        }
        let known = self.run.scales.constraint;
        let (x, peak) = self.inner(&mut r, bounds, known)?;
        self.run.scales.see(peak, 0.0);
        let opening = self.opening(&x);
        advance_equalities(iterate, place, &x, 1.0);
        add_scaled(&mut iterate.blocks[place].residual, 1.0, &opening);
        let (force, mut rest) = r.split_at(iterate.force.len());
        iterate.force.copy_from_slice(force);
        for block in &mut iterate.blocks[..place] {
            let (part, next) = rest.split_at(block.residual.len());
            block.residual.copy_from_slice(part);
            rest = next;
        }
        self.run.work.give(x);
        self.run.work.give(r);
        Ok(())
    }

    /// The response to a change of the multiplier.
    ///
    /// # Errors
    /// Why the inner solve failed.
    pub fn product(&mut self, direction: Vec<f64>) -> Result<Response, QpStatus> {
        let [least, most] = ACCURACIES;
        let accuracy = (INNER * self.run.targets.level / self.relative).clamp(least, most);
        let unknowns = self.problem.stiffness.rows();
        let mut load = self.run.work.zeros(unknowns);
        let columns = self.blocks.contact.columns;
        columns.apply_transposed(&direction, &mut load, self.run.work);
        load.iter_mut().for_each(|value| *value = -*value);
        let bounds = Bounds {
            force: accuracy * norm(&load),
            constraint: accuracy,
        };
        load.resize(unknowns + self.blocks.equality_unknowns(), 0.0);
        let (x, peak) = self.inner(&mut load, bounds, 0.0)?;
        let opening = self.opening(&x);
        Ok(Response {
            direction,
            opening,
            unknowns: x,
            residual: load,
            peak,
        })
    }

    /// Moves `iterate` along a response.
    pub fn advance(&mut self, iterate: &mut QpIterate, response: Response, length: f64) {
        let place = self.blocks.place();
        advance_equalities(iterate, place, &response.unknowns, length);
        let (force, mut rest) = response.residual.split_at(iterate.force.len());
        add_scaled(&mut iterate.force, length, force);
        for block in &mut iterate.blocks[..place] {
            let (part, next) = rest.split_at(block.residual.len());
            add_scaled(&mut block.residual, length, part);
            rest = next;
        }
        let contact = &mut iterate.blocks[place];
        let change: Vec<f64> = response.direction.iter().map(|d| length * d).collect();
        add_scaled(&mut contact.multiplier, 1.0, &change);
        // What leaves the set leaves it whole.
        let set = self.blocks.contact.set;
        set.drop_rounding(&mut contact.multiplier, &change);
        add_scaled(&mut contact.residual, length, &response.opening);
        self.run.scales.see(length.abs() * response.peak, 0.0);
        self.run.work.give(response.unknowns);
        self.run.work.give(response.residual);
    }

    /// Changes the multiplier and settles: one product.
    ///
    /// # Errors
    /// Why the inner solve failed.
    pub fn shift(&mut self, iterate: &mut QpIterate, change: &[f64]) -> Result<(), QpStatus> {
        let mut load = self.run.work.zeros(iterate.force.len());
        let columns = self.blocks.contact.columns;
        columns.apply_transposed(change, &mut load, self.run.work);
        add_scaled(&mut iterate.force, -1.0, &load);
        self.run.work.give(load);
        let contact = &mut iterate.blocks[self.blocks.place()];
        add_scaled(&mut contact.multiplier, 1.0, change);
        self.settle(iterate)
    }

    /// The block of contact.
    pub fn contact(&self) -> ContactBlock<'c> {
        self.blocks.contact
    }

    /// Place of contact among the blocks of the iterate.
    pub fn place(&self) -> usize {
        self.blocks.place()
    }

    /// -C du of packed unknowns.
    fn opening(&mut self, x: &[f64]) -> Vec<f64> {
        let rows = self.blocks.contact.rows;
        let mut opening = vec![0.0; rows.rows()];
        let u = &x[..self.problem.stiffness.rows()];
        rows.apply(u, &mut opening, self.run.work);
        opening.iter_mut().for_each(|value| *value = -*value);
        opening
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
        let geometric = problem.curvature.map(|c| c as &dyn LinearOperator);
        let blocks: &[EqualityBlock<'_>] = &self.blocks.equalities;
        let operator = SaddleOperator {
            stiffness: problem.stiffness,
            geometric,
            blocks,
        };
        let preconditioner =
            problem
                .step
                .preconditioner(problem.stiffness, problem.displacement, blocks);
        let method = Gcr {
            operator: &operator,
            preconditioner: &*preconditioner,
            directions: self.run.directions,
            iterations: self.run.iterations as usize,
        };
        let outcome = method.solve((&mut x, &mut *r), &mut monitor, self.run.work);
        self.outcome.iterations += monitor.iterations;
        let failed = if monitor.interrupted {
            Some(QpStatus::Interrupted)
        } else {
            QpStatus::failure(outcome)
        };
        failed.map_or(Ok((x, monitor.peak)), Err)
    }
}

/// Moves displacement and equality unknowns along packed ones.
fn advance_equalities(iterate: &mut QpIterate, place: usize, unknowns: &[f64], length: f64) {
    let (du, mut dx) = unknowns.split_at(iterate.displacement.len());
    add_scaled(&mut iterate.displacement, length, du);
    for block in &mut iterate.blocks[..place] {
        let (step, next) = dx.split_at(block.multiplier.len());
        add_scaled(&mut block.multiplier, length, step);
        dx = next;
    }
}
