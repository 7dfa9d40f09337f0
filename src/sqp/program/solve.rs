//! Solving one quadratic program: the method that the plan chose on the program's
//! blocks, every iteration reported, and the step that follows.

use super::step::{first_iterate, step_from};
use super::{QuadraticProgram, Step};
use crate::comparisons::StepAbout;
use crate::inequality::{
    LinearSystem, QpIterate, QpNorms, QpOutcome, QpProblem, QpRun, QpScales, QpStatus, QpTargets,
};
use crate::krylov::Outcome;
use crate::krylov::gcr::Directions;
use crate::linalg::vector::{add_scaled, norm};
use crate::linalg::{LinearOperator, Preconditioner, SparseRows, Workspace};
use crate::model::counters::Counters;
use crate::plan::augmentation::VOLUMETRIC;
use crate::precond::Counted;
use crate::saddle::{BlockStep, EqualityBlock, Metric, MultiplierBlock, UpperTriangular};
use crate::sqp::chooser;
use crate::sqp::linear::{Linear, Track};
use crate::sqp::run::Run;

constants! {
    /// Krylov iterations per program.
    const MOST_ITERATIONS: u32 = 600;
    /// With friction, whose faces are more: of linear bodies, and of others.
    const MOST_WITH_FRICTION: [u32; 2] = [2000, 600];
    /// Of a body of finite strain: what takes longer has no stable solution near.
    const MOST_AT_FINITE_STRAIN: u32 = 300;
    /// With a factor of the body: ten are usual, and more than these where the sides do not settle.
    const MOST_BY_FACTOR: u32 = 40;
    /// Force out of balance over its scale from which on the factor of the program before serves: on
    /// an X-ring factors for every program take 7.0 s, this 5.3 s, and a hundredth 4.7 s with some
    /// programs of three hundred iterations.
    const NEAR: f64 = 1e-3;
    /// Share of the force out of balance that the step of a stable body may leave near equilibrium.
    const WORTHWHILE: f64 = 0.5;
    /// Error of the contact pressure, in shear moduli, with which the next tangent is still
    /// that of a stable body: the pressure stands in its stiffness.
    const PRESSURE_ERROR: f64 = 0.05;
}

/// Where a solve of the program starts and ends.
pub(super) struct Solve<'s> {
    /// Increments, multipliers and residuals, solved in place.
    pub(super) iterate: &'s mut QpIterate,
    /// When the program counts as solved.
    pub(super) targets: QpTargets,
    /// Scales of the blocks without a load of their own.
    pub(super) scales: &'s mut QpScales,
    /// Krylov directions of earlier programs, which this one uses and adds to.
    pub(super) directions: &'s mut Directions,
    /// Iterations, at most.
    pub(super) iterations: u32,
}

/// Adds what a program took.
fn count(outcome: &QpOutcome, counters: &mut Counters) {
    counters.set_changes += outcome.set_changes;
    counters.newton_steps += outcome.newton_steps;
    counters.threshold_passes += outcome.threshold_passes;
    counters.contact_products += outcome.products;
}

/// Whether a method has not solved a program that another may.
fn is_lost(status: QpStatus) -> bool {
    matches!(
        status,
        QpStatus::Krylov(_) | QpStatus::ActiveSetCycle | QpStatus::IndefiniteMetric
    )
}

impl QuadraticProgram<'_> {
    /// Solves the program to `level`: by iterations until they have cost as much as a factor of
    /// the body, from the first one on by factors; by iterations alone where the factor, once
    /// ordered, takes more than it may.
    pub(crate) fn solve(&mut self, run: &mut Run<'_>, level: f64) -> (Step, QpOutcome) {
        let may_take_factor = self.factor_cost(run).is_some();
        let begins_by_factor = run.state.by_factor || run.learned.factored.is_some();
        let first = if begins_by_factor && may_take_factor {
            self.solve_by_kept_factor(run, level)
        } else {
            Some(self.solve_with(self.geometric.all(), run, level))
        };
        match first {
            Some(solved) if !is_lost(solved.1.status) => solved,
            _ if may_take_factor && self.take_factor(run) => self.solve_by_factor(run, level),
            Some((_, outcome))
                if may_take_factor
                    && run.learned.factor_is_too_large
                    && outcome.status == QpStatus::Krylov(Outcome::IterationLimit) =>
            {
                self.solve_with(self.geometric.all(), run, level)
            }
            Some(solved) => solved,
            None => self.solve_as_planned(run, level),
        }
    }

    /// Solves the program by the factor of an earlier one where the state is near equilibrium;
    /// none where it is not, or where that does not solve it.
    fn solve_by_kept_factor(&mut self, run: &mut Run<'_>, level: f64) -> Option<(Step, QpOutcome)> {
        let is_near = norm(&self.now.force) <= NEAR * self.force_scale;
        // The stiffness of a linear body is that of the program before.
        let serves = is_near || self.tangent.is_none();
        if !serves || !self.take_kept_factor(run) {
            return None;
        }
        let solved = self.solve_with(self.geometric.all(), run, level);
        let serves = !is_lost(solved.1.status) && self.serves(&solved.0, run);
        serves.then_some(solved)
    }

    /// Solves the program by the method of the plan or the factor in use; without the curvature of
    /// the gaps where it fails or the step has no positive stiffness with it.
    fn solve_as_planned(&self, run: &mut Run<'_>, level: f64) -> (Step, QpOutcome) {
        if let Some(curvature) = &self.geometric.with_contact {
            let solved = self.solve_with(Some(curvature), run, level);
            let failed = matches!(solved.1.status, QpStatus::Krylov(_));
            if !failed && self.serves(&solved.0, run) {
                return solved;
            }
        }
        self.solve_with(self.geometric.load.as_ref(), run, level)
    }

    /// Solves the program by the factor of its body. With friction, where the sides do not settle,
    /// the step is that of the stable body; a smooth one would find another equilibrium by it.
    fn solve_by_factor(&self, run: &mut Run<'_>, level: f64) -> (Step, QpOutcome) {
        if self.now.friction.is_none() {
            return self.solve_as_planned(run, level);
        }
        let (step, mut outcome) = self.solve_with(self.geometric.all(), run, level);
        if !is_lost(outcome.status) {
            return (step, outcome);
        }
        let stable = self.step_by_compliance(run);
        let now = norm(&self.now.force);
        let leads_on = |step: &Step| self.force_after(step, run) <= WORTHWHILE * now;
        let is_near = now <= NEAR * self.force_scale;
        let may_stay = !is_near || stable.as_ref().is_some_and(leads_on);
        let other = if may_stay {
            stable
        } else {
            self.step_on_face(run, level).or(stable)
        };
        match other {
            Some(other) => {
                outcome.status = QpStatus::Solved;
                (other, outcome)
            }
            None => (step, outcome),
        }
    }

    /// Force out of balance after a whole step; infinite where that turns cells inside out.
    fn force_after(&self, step: &Step, run: &mut Run<'_>) -> f64 {
        let before = run.state.clone();
        step.apply(run.state, 1.0);
        let after = run.evaluate();
        run.state.clone_from(&before);
        if after.least_jacobian.is_some_and(|least| least <= 0.0) {
            f64::INFINITY
        } else {
            norm(&after.force)
        }
    }

    /// Whether a step has positive stiffness with the curvature of the gaps. Friction has no
    /// energy that a step could lower, and where forces balance a step is about gaps and volumes,
    /// along which the stiffness of a stable body may have either sign.
    fn serves(&self, step: &Step, run: &mut Run<'_>) -> bool {
        let is_frictional = self.now.friction.is_some();
        let is_balanced =
            norm(&self.now.force) <= self.model.conditions.tolerance * self.force_scale;
        let is_asked = !is_frictional && !is_balanced;
        let curvature = self.geometric.with_contact.as_ref().filter(|_| is_asked);
        curvature.is_none_or(|curvature| {
            self.has_positive_stiffness(curvature, &step.displacement, run.work)
        })
    }

    /// Solves the program to `level` and returns its step; `curvature` is what contact
    /// adds to A, left out where it spoils the stiffness.
    fn solve_with(
        &self,
        curvature: Option<&SparseRows>,
        run: &mut Run<'_>,
        level: f64,
    ) -> (Step, QpOutcome) {
        if self.tangent.is_some() {
            // Products with another tangent.
            run.learned.directions.clear(run.work);
        }
        let targets = QpTargets {
            force_scale: self.force_scale,
            level,
            multiplier_error: self.model.is_rubber().then_some(PRESSURE_ERROR),
        };
        let mut scales = run.state.scales;
        let iterations = self.most_iterations(run);
        let mut iterate = self.start_from(curvature, run);
        let krylov = std::time::Instant::now();
        let displacement = Counted::new(&*self.inverse.displacement);
        let mut track = Track {
            before: run.counters.applications,
            targets,
            displacement: &displacement,
            solutions: self.factored.as_ref().map(|body| &body.solutions),
            watch: &mut run.watch,
            counters: run.counters,
        };
        let solve = Solve {
            iterate: &mut iterate,
            targets,
            scales: &mut scales,
            directions: &mut run.learned.directions,
            iterations,
        };
        let outcome = self.run_method(curvature, solve, &mut track, run.work);
        track.count();
        run.counters.seconds.krylov += krylov.elapsed().as_secs_f64();
        count(&outcome, run.counters);
        run.state.scales = scales;
        (step_from(iterate, run.state), outcome)
    }

    /// Where the method begins: at the state, or at what an exact factor makes of it.
    fn start_from(&self, curvature: Option<&SparseRows>, run: &mut Run<'_>) -> QpIterate {
        let mut iterate = self.first_iterate(curvature, run);
        self.leave_out_advance(curvature, &mut iterate.force);
        if let Some(body) = &self.factored {
            body.begin();
        }
        if self.has_exact_factor() {
            // Where that has no solution the method begins from the state.
            let _ = self.move_by_compliance(&mut iterate, run.work);
        }
        iterate
    }

    /// The iterate after the motion of the supports, with what `curvature` takes off A.
    pub(super) fn first_iterate(
        &self,
        curvature: Option<&SparseRows>,
        run: &mut Run<'_>,
    ) -> QpIterate {
        let mut iterate = first_iterate(run.state, &self.now, self.motion.as_ref());
        let carried = self
            .motion
            .as_ref()
            .and_then(|motion| motion.carried.as_ref());
        if let (Some(curvature), Some(carried)) = (curvature, carried) {
            let mut force = run.work.scratch(carried.len());
            curvature.apply(carried, &mut force, run.work);
            add_scaled(&mut iterate.force, 1.0, &force);
            run.work.give(force);
        }
        iterate
    }

    /// Takes off the force what the whole curvature of the gaps compensates, where that is left
    /// out.
    fn leave_out_advance(&self, curvature: Option<&SparseRows>, force: &mut [f64]) {
        let is_whole = match (curvature, &self.geometric.with_contact) {
            (Some(used), Some(whole)) => std::ptr::eq(used, whole),
            (_, whole) => whole.is_none(),
        };
        if let Some(advance) = self.now.advance.as_ref().filter(|_| !is_whole) {
            add_scaled(force, 1.0, &advance.force);
        }
    }

    /// Hands the program to the method that the plan has chosen: a linear one without
    /// multipliers of contact, one for inequalities otherwise.
    fn run_method(
        &self,
        curvature: Option<&SparseRows>,
        solve: Solve<'_>,
        track: &mut Track<'_, '_>,
        work: &mut Workspace,
    ) -> QpOutcome {
        let displacement = track.displacement;
        let guided = self.model.plan.problem.guided_multipliers;
        let pressure = self.pressure();
        let linear = chooser::linear(self.model.plan);
        match linear.filter(|_| self.factored.is_none()) {
            Some(method) => {
                let system = LinearSystem {
                    stiffness: self.stiffness(),
                    displacement,
                    pressure: pressure.as_ref(),
                    targets: solve.targets,
                    iterations: solve.iterations as usize,
                };
                let method = &*method;
                Linear { method, system }.solve(solve.iterate, solve.scales, track, work)
            }
            None => {
                let step = self.block_step(displacement, work);
                let blocks = self.blocks();
                let problem = self.problem(curvature, displacement, &blocks, &*step);
                let mut progress = |norms: &QpNorms, scales: &QpScales, active: usize| {
                    track.iteration(norms, scales, active.saturating_sub(guided))
                };
                let mut run = QpRun {
                    targets: solve.targets,
                    scales: solve.scales,
                    iterations: solve.iterations,
                    directions: solve.directions,
                    progress: &mut progress,
                    work,
                };
                chooser::contact(self.model.plan, problem).solve(solve.iterate, &mut run)
            }
        }
    }

    /// Iterations of a method for inequalities, at most.
    fn most_iterations(&self, run: &Run<'_>) -> u32 {
        if self.factored.is_some() {
            return MOST_BY_FACTOR;
        }
        let most = match &self.tangent {
            None if self.model.plan.has_friction() => MOST_WITH_FRICTION[0],
            None => MOST_ITERATIONS,
            Some(_) if self.model.plan.has_friction() => MOST_WITH_FRICTION[1],
            Some(_) => MOST_AT_FINITE_STRAIN,
        };
        self.factor_cost(run).map_or(most, |price| price.min(most))
    }

    /// Iterations that cost as much as a factor of the body; none where that takes more than it may.
    pub(super) fn factor_cost(&self, run: &Run<'_>) -> Option<u32> {
        let price = self.model.plan.factor_cost();
        price.filter(|_| !run.learned.factor_is_too_large)
    }

    /// The body less `curvature`, on this program's contacts.
    pub(super) fn problem<'p>(
        &'p self,
        curvature: Option<&'p SparseRows>,
        displacement: &'p dyn Preconditioner,
        blocks: &'p [MultiplierBlock<'p>],
        step: &'p dyn BlockStep,
    ) -> QpProblem<'p> {
        QpProblem {
            stiffness: self.stiffness(),
            curvature,
            augmentation: self.augmentation.as_ref(),
            displacement,
            step,
            blocks,
        }
    }

    /// The step of GCR.
    pub(super) fn block_step(
        &self,
        displacement: &dyn Preconditioner,
        work: &mut Workspace,
    ) -> Box<dyn BlockStep + '_> {
        if let Some(body) = &self.factored {
            return Box::new(body.step());
        }
        let plan = self.model.plan;
        let other = self.pressure().and_then(|pressure| {
            let about = StepAbout {
                displacement,
                pressure: &pressure,
                force: &self.now.force,
                constraint: &self.now.constraint,
            };
            let comparisons = plan.comparisons.as_ref()?;
            comparisons.block_step(plan.decisions.saddle.method, &about, work)
        });
        other.unwrap_or_else(|| {
            let volume = match self.tangent {
                Some(_) => VOLUMETRIC,
                None => plan.augmentation(),
            };
            Box::new(UpperTriangular {
                share: plan.augmented_share(volume),
            })
        })
    }

    /// Internal pressure and contact pressure.
    pub(super) fn blocks(&self) -> Vec<MultiplierBlock<'_>> {
        let pressure = self.pressure().map(MultiplierBlock::from);
        pressure.into_iter().chain([self.contact()]).collect()
    }

    /// The internal pressure as an equality block about the state; none in displacement
    /// form.
    pub(super) fn pressure(&self) -> Option<EqualityBlock<'_>> {
        let block = self.model.prepared.pressure.as_ref()?;
        let tangent = self.tangent.as_ref();
        let coupling = tangent.map_or(&block.coupling as &dyn LinearOperator, |t| &t.coupling);
        let stabilisation = block.stabilisation.as_ref();
        Some(EqualityBlock {
            shared: None,
            rows: coupling,
            columns: coupling,
            stabilisation: stabilisation.map(|s| s as &dyn LinearOperator),
            metric: (self.coarse.as_ref()).map_or(&block.metric as &dyn Preconditioner, |m| m),
            joint: Some(tangent.map_or(&block.body as &dyn LinearOperator, |t| &t.body)),
        })
    }

    /// Rows of the gaps and slips.
    pub(super) fn contact_rows(&self) -> &SparseRows {
        self.geometric.rows.as_ref().unwrap_or(&self.now.coupling)
    }

    /// Contact pressure of all obstacles.
    fn contact(&self) -> MultiplierBlock<'_> {
        MultiplierBlock {
            rows: self.contact_rows(),
            columns: &self.now.coupling,
            stabilisation: None,
            metric: Metric::Dense {
                matrix: self.metric(),
                weights: &self.metric.weights,
                moduli: &self.model.interfaces.moduli,
                // The factor solves for both pressures together.
                shared: (self.metric.shared.as_ref()).filter(|_| self.factored.is_none()),
            },
            set: self.now.contact_set(),
            joint: None,
        }
    }
}
