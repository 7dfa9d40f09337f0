//! One quadratic program: the body with frozen normals, the curvature of the
//! gap in its stiffness, and the metric of the candidate surface.

use std::sync::Arc;

use super::contact_metric::ContactMetric;
use super::counters::{Counters, timed};
use super::drive::Drive;
use super::evaluate::{Context, Evaluation};
use super::linear::{Linear, Track};
use super::pressures::pressure_tangent;
use super::stability::Accuracy;
use super::state::State;
use super::tangent::Tangent;
use super::upkeep::inverse;
use super::watch::Watch;
use crate::contact::gap::curvature;
use crate::inequality::{
    OneLevel, QpIterate, QpNorms, QpOutcome, QpProblem, QpRun, QpScales, QpStatus, QpTargets,
    choose,
};
use crate::krylov::Verdict;
use crate::linalg::vector::{add_scaled, dot, norm};
use crate::linalg::{LinearOperator, Preconditioner, SparseRows, Workspace};
use crate::obstacle::Obstacle;
use crate::plan::{Approximation, SaddleMethod};
use crate::precond::Counted;
use crate::saddle::{BlockStep, MultiplierBlock, arrow_hurwicz_ratio};

/// Krylov iterations per program.
const MOST_ITERATIONS: u32 = 600;
/// Of a body of finite strain: what takes longer has no stable solution near.
const MOST_AT_FINITE_STRAIN: u32 = 300;
/// Aim of a program below the tolerance, for what the recomputed residual adds.
const MARGIN: f64 = 0.95;

/// A step of all unknowns.
pub(super) struct Step {
    pub(super) displacement: Vec<f64>,
    pressure: Vec<f64>,
    /// New multipliers minus old ones.
    multiplier: Vec<f64>,
    active: Vec<bool>,
}

impl Step {
    pub(super) fn apply(&self, state: &mut State, length: f64) {
        add_scaled(&mut state.displacement, length, &self.displacement);
        add_scaled(&mut state.pressure, length, &self.pressure);
        add_scaled(&mut state.multiplier, length, &self.multiplier);
        state.active.copy_from_slice(&self.active);
    }
}

/// One quadratic program.
pub(super) struct Program<'a> {
    context: Context<'a>,
    /// None for a linear body.
    tangent: Option<Tangent>,
    inverse: Arc<Approximation>,
    /// What supports move in this program; none where they stand still.
    motion: Option<Vec<f64>>,
    /// Residuals after that motion.
    now: Evaluation,
    /// What pressures that follow the body take off its stiffness.
    released: Option<SparseRows>,
    /// What the curvature of the gaps takes off, with `released`.
    curvature: Option<SparseRows>,
    metric: ContactMetric,
    force_scale: f64,
}

impl<'a> Program<'a> {
    /// Takes `now` over; `first_force` grows with what the motion of supports asks
    /// for.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn new(
        context: &Context<'a>,
        state: &mut State,
        drive: &Drive,
        (now, motion): (&Evaluation, Option<Vec<f64>>),
        first_force: &mut f64,
        watch: &Watch<'_>,
        counters: &mut Counters,
        work: &mut Workspace,
    ) -> Self {
        let tangent = timed(&mut counters.seconds.assemble, || {
            Tangent::new(context, state, work)
        });
        let inverse = inverse(context, state, tangent.as_ref(), watch, counters);
        let now = match (&tangent, &motion) {
            (Some(tangent), Some(motion)) => tangent.after(motion, context, state, now, work),
            _ => now.clone(),
        };
        *first_force = first_force.max(norm(&now.force));
        timed(&mut counters.seconds.contact, || {
            let metric = ContactMetric::new(context, &inverse, &now, work);
            counters.applications += metric.applications;
            let expected = metric.expected_contact_norm(&now, state, work);
            let released = pressure_tangent(context, &state.displacement, drive.load);
            let curvature = curvature_of(context, state, drive).map(|own| match &released {
                Some(released) => own.plus(released),
                None => own,
            });
            Self {
                context: *context,
                released,
                curvature,
                metric,
                force_scale: now.force_scale(*first_force).max(expected),
                tangent,
                inverse,
                motion,
                now,
            }
        })
    }

    /// Residuals that the program starts from.
    pub(super) fn start(&self) -> &Evaluation {
        &self.now
    }

    fn stiffness(&self) -> &dyn LinearOperator {
        match &self.tangent {
            Some(tangent) => &tangent.stiffness,
            None => &self.context.prepared.stiffness,
        }
    }

    /// All that loads and contacts take off the stiffness.
    fn taken_off(&self) -> Option<&SparseRows> {
        self.curvature.as_ref().or(self.released.as_ref())
    }

    /// The tolerance, or `goal` where the gap is curved.
    fn targets(&self, goal: f64) -> QpTargets {
        QpTargets {
            force_scale: self.force_scale,
            level: goal.max(MARGIN * self.context.tolerance),
        }
    }

    /// Solves the program; without the curvature of the gaps where it fails or
    /// the step has no positive stiffness with it.
    pub(super) fn solve(
        &self,
        state: &mut State,
        goal: f64,
        watch: &mut Watch<'_>,
        counters: &mut Counters,
        work: &mut Workspace,
    ) -> (Step, QpOutcome) {
        if let Some(curvature) = &self.curvature {
            let solved = self.solve_with(Some(curvature), state, goal, watch, counters, work);
            let failed = matches!(solved.1.status, QpStatus::Krylov(_));
            if !failed && self.has_positive_stiffness(curvature, &solved.0.displacement, work) {
                return solved;
            }
        }
        self.solve_with(self.released.as_ref(), state, goal, watch, counters, work)
    }

    #[allow(clippy::too_many_arguments)]
    fn solve_with(
        &self,
        curvature: Option<&SparseRows>,
        state: &mut State,
        goal: f64,
        watch: &mut Watch<'_>,
        counters: &mut Counters,
        work: &mut Workspace,
    ) -> (Step, QpOutcome) {
        let targets = self.targets(goal);
        let mut scales = state.scales;
        if self.tangent.is_some() {
            // Products with another tangent.
            state.directions.clear(work);
        }
        let now = &self.now;
        let mut iterate = first_iterate(state, now, self.motion.as_deref());
        let krylov = std::time::Instant::now();
        let displacement = Counted::new(&*self.inverse.displacement);
        let mut track = Track {
            before: counters.applications,
            force_scale: targets.force_scale,
            displacement: &displacement,
            watch,
            counters,
        };
        let blocks = self.blocks();
        let outcome = match self.context.plan.saddle.method {
            SaddleMethod::ConjugateGradients
            | SaddleMethod::Stationary
            | SaddleMethod::Minres
            | SaddleMethod::UzawaCg => {
                let linear = Linear {
                    method: self.context.plan.saddle.method,
                    stiffness: self.stiffness(),
                    displacement: &displacement,
                    blocks: &blocks,
                    iterations: MOST_ITERATIONS as usize,
                };
                linear.solve(&mut iterate, &targets, &mut scales, &mut track, work)
            }
            SaddleMethod::Gcr | SaddleMethod::ArrowHurwicz => {
                let problem = QpProblem {
                    stiffness: self.stiffness(),
                    curvature,
                    displacement: &displacement,
                    step: self.block_step(&displacement, &blocks, now, work),
                    equality: &blocks,
                    coupling: &now.coupling,
                    metric: &self.metric.matrix,
                    weights: &self.metric.weights,
                };
                let mut progress = |norms: &QpNorms, scales: &QpScales, active: usize| {
                    track.iteration(norms, scales, active)
                };
                let mut run = QpRun {
                    targets,
                    scales: &mut scales,
                    iterations: match self.tangent {
                        Some(_) => MOST_AT_FINITE_STRAIN,
                        None => MOST_ITERATIONS,
                    },
                    directions: &mut state.directions,
                    progress: &mut progress,
                    work,
                };
                choose(self.context.plan.contact.method, problem).solve(&mut iterate, &mut run)
            }
        };
        track.count();
        counters.seconds.krylov += krylov.elapsed().as_secs_f64();
        counters.set_changes += outcome.set_changes;
        counters.contact_products += outcome.products;
        state.scales = scales;
        (step_from(iterate, state), outcome)
    }

    /// The step of GCR; Arrow-Hurwicz takes its ratio from the first residual.
    fn block_step(
        &self,
        displacement: &dyn Preconditioner,
        blocks: &[MultiplierBlock<'_>],
        now: &Evaluation,
        work: &mut Workspace,
    ) -> BlockStep {
        match (self.context.plan.saddle.method, blocks.first()) {
            (SaddleMethod::ArrowHurwicz, Some(pressure)) => BlockStep::ArrowHurwicz {
                ratio: arrow_hurwicz_ratio(
                    displacement,
                    pressure,
                    &now.force,
                    &now.constraint,
                    work,
                ),
            },
            _ if self.tangent.is_some() => BlockStep::Augmented {
                share: self.context.plan.augmented_share(),
            },
            _ => BlockStep::UpperTriangular,
        }
    }

    /// K^-1 `force` among the motions that volume and the present
    /// contacts admit; none where it was stopped.
    pub(super) fn invert(
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
        let problem = QpProblem {
            stiffness: self.stiffness(),
            curvature: self.taken_off(),
            displacement: &displacement,
            step: self.block_step(&displacement, &blocks, &self.now, work),
            equality: &blocks,
            coupling: &self.now.coupling,
            metric: &self.metric.matrix,
            weights: &self.metric.weights,
        };
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
    pub(super) fn curvature_along(&self, x: &[f64], work: &mut Workspace) -> f64 {
        let mut product = work.scratch(x.len());
        self.stiffness().apply(x, &mut product, work);
        let mut sum = dot(x, &product);
        if let Some(taken_off) = self.taken_off() {
            taken_off.apply(x, &mut product, work);
            sum -= dot(x, &product);
        }
        work.give(product);
        sum
    }

    fn has_positive_stiffness(
        &self,
        curvature: &SparseRows,
        step: &[f64],
        work: &mut Workspace,
    ) -> bool {
        let mut product = work.scratch(step.len());
        self.stiffness().apply(step, &mut product, work);
        let stiff = dot(step, &product);
        curvature.apply(step, &mut product, work);
        let released = dot(step, &product);
        work.give(product);
        stiff >= released
    }

    fn blocks(&self) -> Vec<MultiplierBlock<'_>> {
        let pressure = self.context.prepared.pressure.iter();
        let tangent = self.tangent.as_ref();
        pressure
            .map(|block| MultiplierBlock {
                coupling: tangent.map_or(&block.coupling as &dyn LinearOperator, |t| &t.coupling),
                stabilisation: block
                    .stabilisation
                    .as_ref()
                    .map(|s| s as &dyn LinearOperator),
                metric: &block.metric,
                joint: Some(tangent.map_or(&block.body as &dyn LinearOperator, |t| &t.body)),
            })
            .collect()
    }
}

fn first_iterate(state: &State, now: &Evaluation, motion: Option<&[f64]>) -> QpIterate {
    let still = || vec![0.0; state.displacement.len()];
    QpIterate {
        displacement: motion.map_or_else(still, <[f64]>::to_vec),
        equality: vec![0.0; state.pressure.len()],
        multiplier: state.multiplier.clone(),
        force: now.force.clone(),
        constraint: now.constraint.clone(),
        gap: now.gap.clone(),
        active: state.active.clone(),
    }
}

fn step_from(iterate: QpIterate, state: &State) -> Step {
    let multiplier = iterate.multiplier.iter().zip(&state.multiplier);
    Step {
        multiplier: multiplier.map(|(new, old)| new - old).collect(),
        displacement: iterate.displacement,
        pressure: iterate.equality,
        active: iterate.active,
    }
}

/// Curvature of the gaps under the present contact pressure; none where it
/// vanishes.
fn curvature_of(context: &Context<'_>, state: &State, drive: &Drive) -> Option<SparseRows> {
    let under_pressure = state.multiplier.iter().any(|&l| l != 0.0);
    if context.interfaces.are_flat() || !under_pressure {
        return None;
    }
    let obstacles = context
        .interfaces
        .obstacles(drive, context.plan.units.length);
    let list = context.interfaces.list.iter();
    let surfaces: Vec<_> = list
        .zip(&obstacles)
        .map(|(interface, obstacle)| {
            let pressure = &state.multiplier[interface.range()];
            (&interface.surface, obstacle as &dyn Obstacle, pressure)
        })
        .collect();
    let body = context.deformed(&state.displacement);
    Some(curvature(&body, &surfaces, &context.prepared.is_held))
}
