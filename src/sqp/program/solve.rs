//! Solving one quadratic program: the method that the plan chose on the program's
//! blocks, every iteration reported, and the step that follows.

use std::sync::Arc;

use super::step::{first_iterate, step_from};
use super::{QuadraticProgram, Step};
use crate::inequality::{
    QpIterate, QpNorms, QpOutcome, QpProblem, QpRun, QpScales, QpStatus, QpTargets,
};
use crate::krylov::Outcome;
use crate::krylov::gcr::Directions;
use crate::krylov::outlook::Outlook;
use crate::linalg::{LinearOperator, Preconditioner, SparseRows, Workspace};
use crate::plan::augmentation::VOLUMETRIC;
use crate::plan::second_attempt::Programs;
use crate::precond::Counted;
use crate::saddle::{BlockStep, EqualityBlock, Metric, MultiplierBlock, Status, UpperTriangular};
use crate::scene::ContactMethod;
use crate::sqp::chooser;
use crate::sqp::linear::{Linear, Track};
use crate::sqp::run::Run;
use crate::sqp::saddle_layout::SaddleLayout;

/// Krylov iterations per program.
const MOST_ITERATIONS: u32 = 600;
/// With friction, whose faces are more: of linear bodies, and of others.
const MOST_WITH_FRICTION: [u32; 2] = [2000, 600];
/// Of a body of finite strain: what takes longer has no stable solution near.
const MOST_AT_FINITE_STRAIN: u32 = 300;
/// Of one whose factor is small: it costs as much as some twenty iterations.
const MOST_BEFORE_FACTOR: u32 = 80;
/// Error of the contact pressure, in shear moduli, with which the next tangent is still
/// that of a stable body: the pressure stands in its stiffness.
const PRESSURE_ERROR: f64 = 0.05;

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
    /// What the saddle point is assembled and ordered by, where its factor is the method.
    pub(super) layout: Option<Arc<SaddleLayout>>,
}

impl QuadraticProgram<'_> {
    /// Solves the program to `level`; without the
    /// curvature of the gaps where it fails or the step has no positive stiffness with
    /// it.
    pub(crate) fn solve(&self, run: &mut Run<'_>, level: f64) -> (Step, QpOutcome) {
        let solved = self.solve_as_planned(run, level);
        let is_lost = matches!(solved.1.status, QpStatus::Krylov(_));
        let may_factorise = self.tangent.is_some() && self.model.plan.has_small_factor();
        if run.by_factor || !is_lost || !may_factorise {
            return solved;
        }
        run.by_factor = true;
        run.counters.failed_programs += 1;
        self.solve_as_planned(run, level)
    }

    /// Solves the program by the method of the plan, or by a factor where one has taken
    /// over.
    fn solve_as_planned(&self, run: &mut Run<'_>, level: f64) -> (Step, QpOutcome) {
        if let Some(curvature) = &self.curvature {
            let solved = self.solve_with(Some(curvature), run, level);
            let failed = matches!(solved.1.status, QpStatus::Krylov(_));
            let step = &solved.0.displacement;
            // Friction has no energy that a step could lower.
            let is_rough = self.now.friction.is_some();
            let serves = is_rough || self.has_positive_stiffness(curvature, step, &mut run.work);
            if !failed && serves {
                return solved;
            }
        }
        self.solve_with(self.released.as_ref(), run, level)
    }

    /// Solves the program to `level` and returns its step; `curvature` is what contact
    /// adds to A, left out where it spoils the stiffness.
    fn solve_with(
        &self,
        curvature: Option<&SparseRows>,
        run: &mut Run<'_>,
        level: f64,
    ) -> (Step, QpOutcome) {
        let Run {
            state,
            learned,
            watch,
            counters,
            work,
            by_factor,
            ..
        } = run;
        let is_factorised = *by_factor || self.model.plan.programs == Programs::Factorised;
        let layout = is_factorised.then(|| learned.layout(&self.model));
        if self.tangent.is_some() {
            // Products with another tangent.
            learned.directions.clear(work);
        }
        let targets = QpTargets {
            force_scale: self.force_scale,
            level,
            multiplier_error: self.model.is_rubber().then_some(PRESSURE_ERROR),
        };
        let mut scales = state.scales;
        let mut iterate = first_iterate(state, &self.now, self.motion.as_deref());
        if layout.is_none() {
            self.start_from_prediction(&mut iterate);
        }
        let krylov = std::time::Instant::now();
        let displacement = Counted::new(&*self.inverse.displacement);
        let mut track = Track {
            before: counters.applications,
            targets,
            outlook: self.outlook(),
            active: 0,
            is_hopeless: false,
            displacement: &displacement,
            watch,
            counters,
        };
        let solve = Solve {
            iterate: &mut iterate,
            targets,
            scales: &mut scales,
            directions: &mut learned.directions,
            layout,
        };
        let mut outcome = self.run_method(curvature, solve, &mut track, work);
        track.count();
        if track.is_hopeless && outcome.status == QpStatus::Interrupted {
            outcome.status = QpStatus::Krylov(Outcome::Stagnation);
        }
        counters.seconds.krylov += krylov.elapsed().as_secs_f64();
        counters.set_changes += outcome.set_changes;
        counters.newton_steps += outcome.newton_steps;
        counters.threshold_passes += outcome.threshold_passes;
        counters.contact_products += outcome.products;
        state.scales = scales;
        (step_from(iterate, state), outcome)
    }

    /// Takes the predicted sides of a body that nothing touches yet: those of the first face,
    /// which are not sought again.
    fn start_from_prediction(&self, iterate: &mut QpIterate) {
        let is_asked = self.model.plan.contact.method == ContactMethod::OneLevel;
        let Some(contact) = iterate.blocks.last_mut().filter(|_| is_asked) else {
            return;
        };
        let is_open = |(&status, &value): (&Status, &f64)| status == Status::Open && value == 0.0;
        let is_smooth = !self.predicted.contains(&Status::Slip) && self.now.friction.is_none();
        if is_smooth
            && self.predicted.len() == contact.status.len()
            && contact.status.iter().zip(&contact.multiplier).all(is_open)
        {
            contact.status.copy_from_slice(&self.predicted);
        }
    }

    /// Whether iterations lead on, where something else may be tried; none for rubber,
    /// whose programs are worth what they bring, and for methods that nest iterations.
    fn outlook(&self) -> Option<Outlook> {
        let plan = self.model.plan;
        let is_plain = plan.programs == Programs::AsPlanned && !plan.contact.method.is_nested();
        let is_wanted = is_plain && self.tangent.is_none() && !plan.rungs().is_empty();
        is_wanted.then(|| Outlook::new(MOST_ITERATIONS))
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
        if let Some(layout) = solve.layout.clone() {
            return self.run_factorised(curvature, (solve, &layout), track, work);
        }
        let displacement = track.displacement;
        let guided = self.model.plan.guided_multipliers;
        let pressure = self.pressure();
        match chooser::linear(self.model.plan.saddle.method) {
            Some(method) => {
                let linear = Linear {
                    method: &*method,
                    stiffness: self.stiffness(),
                    displacement,
                    pressure: pressure.as_ref(),
                    targets: solve.targets,
                    iterations: MOST_ITERATIONS as usize,
                };
                linear.solve(solve.iterate, solve.scales, track, work)
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
                    iterations: match self.tangent {
                        _ if self.model.plan.has_friction() => {
                            MOST_WITH_FRICTION[usize::from(self.tangent.is_some())]
                        }
                        Some(_) if self.model.plan.has_small_factor() => MOST_BEFORE_FACTOR,
                        Some(_) => MOST_AT_FINITE_STRAIN,
                        None => MOST_ITERATIONS,
                    },
                    directions: solve.directions,
                    progress: &mut progress,
                    work,
                };
                let method = self.model.plan.contact.method;
                chooser::contact(method, problem).solve(solve.iterate, &mut run)
            }
        }
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
    ) -> Box<dyn BlockStep> {
        let now = (&self.now.force[..], &self.now.constraint[..]);
        let method = self.model.plan.saddle.method;
        let other = self
            .pressure()
            .and_then(|pressure| chooser::block_step(method, displacement, &pressure, now, work));
        other.unwrap_or_else(|| {
            let plan = self.model.plan;
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

    /// Contact pressure of all obstacles.
    fn contact(&self) -> MultiplierBlock<'_> {
        MultiplierBlock {
            rows: self.turned.as_ref().unwrap_or(&self.now.coupling),
            columns: &self.now.coupling,
            stabilisation: None,
            metric: Metric::Dense {
                matrix: &*self.metric.matrix,
                weights: &self.metric.weights,
                moduli: &self.model.interfaces.moduli,
                shared: self.metric.shared.as_ref(),
            },
            set: self.now.contact_set(),
            joint: None,
        }
    }
}
