//! One quadratic program: the body with frozen normals, the curvature of the
//! gap in its stiffness, and the metric of the candidate surface.

mod step;
mod stiffness;

use std::sync::Arc;

use super::contact_metric::ContactMetric;
use super::counters::{Counters, timed};
use super::drive::Drive;
use super::evaluate::{Context, Evaluation};
use super::linear::{Linear, Track};
use super::pressures::pressure_tangent;
use super::state::State;
use super::tangent::Tangent;
use super::upkeep::inverse;
use super::watch::Watch;
use crate::contact::gap::curvature;
use crate::inequality::{
    QpNorms, QpOutcome, QpProblem, QpRun, QpScales, QpStatus, QpTargets, choose,
};
use crate::linalg::vector::norm;
use crate::linalg::{LinearOperator, Preconditioner, SparseRows, Workspace};
use crate::obstacle::Obstacle;
use crate::plan::{Approximation, SaddleMethod};
use crate::precond::Counted;
use crate::saddle::{BlockStep, MultiplierBlock, arrow_hurwicz_ratio};
pub(super) use step::Step;
use step::{first_iterate, step_from};

/// Krylov iterations per program.
const MOST_ITERATIONS: u32 = 600;
/// Of a body of finite strain: what takes longer has no stable solution near.
const MOST_AT_FINITE_STRAIN: u32 = 300;
/// Aim of a program below the tolerance, for what the recomputed residual adds.
const MARGIN: f64 = 0.95;

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
                let problem = self.problem(curvature, &displacement, &blocks, work);
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

    /// The body less `curvature`, on this program's contacts.
    fn problem<'p>(
        &'p self,
        curvature: Option<&'p SparseRows>,
        displacement: &'p dyn Preconditioner,
        blocks: &'p [MultiplierBlock<'p>],
        work: &mut Workspace,
    ) -> QpProblem<'p> {
        QpProblem {
            stiffness: self.stiffness(),
            curvature,
            displacement,
            step: self.block_step(displacement, blocks, work),
            equality: blocks,
            coupling: &self.now.coupling,
            metric: &self.metric.matrix,
            weights: &self.metric.weights,
        }
    }

    /// The step of GCR; Arrow-Hurwicz takes its ratio from the first residual.
    fn block_step(
        &self,
        displacement: &dyn Preconditioner,
        blocks: &[MultiplierBlock<'_>],
        work: &mut Workspace,
    ) -> BlockStep {
        match (self.context.plan.saddle.method, blocks.first()) {
            (SaddleMethod::ArrowHurwicz, Some(pressure)) => BlockStep::ArrowHurwicz {
                ratio: arrow_hurwicz_ratio(
                    displacement,
                    pressure,
                    &self.now.force,
                    &self.now.constraint,
                    work,
                ),
            },
            _ if self.tangent.is_some() => BlockStep::Augmented {
                share: self.context.plan.augmented_share(),
            },
            _ => BlockStep::UpperTriangular,
        }
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
