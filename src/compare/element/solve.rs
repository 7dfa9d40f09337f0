//! One increment: residuals, the program, residuals again.

use crate::compare::element::body::EnrichedBody;
use crate::inequality::{
    InequalitySolver, OneLevel, QpIterate, QpNorms, QpOutcome, QpProblem, QpRun, QpScales,
    QpTargets,
};
use crate::linalg::vector::{add_scaled, norm};
use crate::linalg::{Held, LinearOperator, Workspace};
use crate::model::drive::Drive;
use crate::model::ending::Ending;
use crate::model::evaluate::Evaluation;
use crate::model::held::{mask, norm_of};
use crate::model::state::State;
use crate::precond::Counted;
use crate::precond::compliance::Compliance;
use crate::report::{Cause, Termination};
use crate::saddle::{
    AdmissibleSet, EqualityBlock, Metric, MultiplierBlock, ProductSet, SetPart, UpperTriangular,
};
use crate::session::body::Increment;
use crate::sqp::contact_metric::predicted_load;
use crate::sqp::increment::{ending, residuals};
use crate::sqp::linear::Track;
use crate::sqp::program::step::first_iterate;
use crate::sqp::verdict::{Verdict, of_status};

/// Krylov iterations per program.
const MOST_ITERATIONS: u32 = 1000;
/// Programs per increment.
const MOST_PROGRAMS: u32 = 40;
/// Reduction asked of a program with a curved gap.
const REDUCTION: f64 = 1e-2;
/// Aim of a program below the tolerance, for what the recomputed residual adds.
const MARGIN: f64 = 0.95;

impl EnrichedBody {
    /// A u + B^T p, all rows.
    pub(crate) fn internal_force(&self, state: &State, work: &mut Workspace) -> Vec<f64> {
        let mut force = vec![0.0; state.displacement.len()];
        let mut part = work.scratch(force.len());
        let matrix = &self.data.stiffness.matrix;
        matrix.apply(&state.displacement, &mut force, work);
        let transposed = &self.data.pressure.coupling.transposed;
        transposed.apply(&state.pressure, &mut part, work);
        add_scaled(&mut force, 1.0, &part);
        work.give(part);
        force
    }

    /// Residuals of `state` under its drive.
    fn evaluate(&self, state: &State, work: &mut Workspace) -> Evaluation {
        let held = &Held::of_entries(self.data.space.components, self.data.held.clone());
        let drive = &state.drive;
        let mut force: Vec<f64> = self.load.iter().map(|value| value * drive.load).collect();
        mask(held, &mut force);
        let mut out = Evaluation {
            load_norm: norm(&force),
            ..Evaluation::default()
        };
        add_scaled(&mut force, -1.0, &self.internal_force(state, work));
        self.add_contact(state, &mut force, &mut out, work);
        if drive.moves_supports() {
            out.reaction_norm = norm_of(held, &force);
        }
        mask(held, &mut force);
        out.force = force;
        out.constraint = self.constraint(state, work);
        out
    }

    /// -(B u - S p).
    fn constraint(&self, state: &State, work: &mut Workspace) -> Vec<f64> {
        let block = &self.data.pressure;
        let mut residual = vec![0.0; state.pressure.len()];
        let matrix = &block.coupling.matrix;
        matrix.apply(&state.displacement, &mut residual, work);
        residual.iter_mut().for_each(|value| *value = -*value);
        if let Some(stabilisation) = &block.stabilisation {
            let mut product = work.scratch(residual.len());
            stabilisation.apply(&state.pressure, &mut product, work);
            add_scaled(&mut residual, 1.0, &product);
            work.give(product);
        }
        residual
    }

    /// Moves the state to equilibrium under `drive`: whole steps, without a search.
    pub(crate) fn solve(&self, run: &mut Increment<'_>, drive: &Drive) -> Ending {
        self.prescribe(drive, &mut run.state.displacement);
        run.state.drive = drive.clone();
        let tolerance = self.plan.settings.tolerance;
        let mut now = self.evaluate(run.state, &mut run.work);
        let first = norm(&now.force);
        let mut failed = None;
        for _ in 0..MOST_PROGRAMS {
            let worst = residuals(run.state, &now, first).largest();
            let verdict = match run.watch.stopped(&run.counters) {
                _ if !worst.is_finite() => Some(Verdict::failed(Cause::NotFinite)),
                _ if worst <= tolerance => Some(Verdict::stopped(Termination::Converged)),
                Some(termination) => Some(Verdict::stopped(termination)),
                None => failed,
            };
            if let Some(verdict) = verdict {
                return ending(run.state, (&now, first), verdict, tolerance);
            }
            run.counters.sqp_iterations += 1;
            let goal = match self.interfaces.are_flat() {
                true => 0.0,
                false => REDUCTION * worst,
            };
            let outcome = self.solve_program(run, (&now, first), goal);
            run.counters.set_changes += outcome.set_changes;
            failed = of_status(outcome.status, &run.watch);
            now = self.evaluate(run.state, &mut run.work);
        }
        let verdict = Verdict::failed(Cause::IterationLimit);
        ending(run.state, (&now, first), verdict, tolerance)
    }

    /// Solves the program about the present state, whose residuals are `now`, and takes
    /// its step.
    fn solve_program(
        &self,
        run: &mut Increment<'_>,
        (now, first): (&Evaluation, f64),
        goal: f64,
    ) -> QpOutcome {
        let compliance = self.compliance(&now.coupling);
        let expected = predicted_load(&compliance, now, run.state, &mut run.work);
        let displacement = Counted::new(&self.data.displacement);
        let blocks = [
            MultiplierBlock::from(self.pressure_block()),
            contact_block(now, &compliance),
        ];
        let problem = OneLevel::new(QpProblem {
            stiffness: &self.data.stiffness,
            curvature: None,
            augmentation: None,
            displacement: &displacement,
            step: &UpperTriangular { share: 1.0 },
            blocks: &blocks,
        });
        let targets = QpTargets {
            force_scale: now.force_scale(first).max(expected),
            level: goal.max(MARGIN * self.plan.settings.tolerance),
            multiplier_error: None,
        };
        let mut iterate = first_iterate(run.state, now, None);
        let mut scales = run.state.scales;
        let krylov = std::time::Instant::now();
        let mut track = Track {
            before: run.counters.applications,
            targets,
            displacement: &displacement,
            solutions: None,
            watch: &mut run.watch,
            counters: &mut run.counters,
        };
        let mut progress = |norms: &QpNorms, scales: &QpScales, active: usize| {
            track.iteration(norms, scales, active)
        };
        let mut solve = QpRun {
            targets,
            scales: &mut scales,
            iterations: MOST_ITERATIONS,
            directions: &mut run.learned.directions,
            progress: &mut progress,
            work: &mut run.work,
        };
        let outcome = problem.solve(&mut iterate, &mut solve);
        track.count();
        run.counters.seconds.krylov += krylov.elapsed().as_secs_f64();
        run.state.scales = scales;
        take_step(run.state, iterate);
        outcome
    }

    /// The pressure block.
    fn pressure_block(&self) -> EqualityBlock<'_> {
        let block = &self.data.pressure;
        let stabilisation = block.stabilisation.as_ref();
        EqualityBlock {
            shared: None,
            rows: &block.coupling,
            columns: &block.coupling,
            stabilisation: stabilisation.map(|s| s as &dyn LinearOperator),
            metric: &*block.metric,
            joint: None,
        }
    }

    /// Makes `ending` describe the state that is kept.
    pub(crate) fn describe(&self, run: &mut Increment<'_>, ending: &mut Ending) {
        let now = self.evaluate(run.state, &mut run.work);
        ending.force_scale = now.force_scale(0.0);
        ending.max_penetration = now.max_penetration;
        ending.residuals = residuals(run.state, &now, 0.0);
    }
}

/// Contact pressure of all obstacles, in the metric `compliance`.
fn contact_block<'a>(now: &'a Evaluation, compliance: &'a Compliance) -> MultiplierBlock<'a> {
    MultiplierBlock {
        rows: &now.coupling,
        columns: &now.coupling,
        stabilisation: None,
        metric: Metric::Dense {
            matrix: compliance,
            weights: &[],
            moduli: &[],
            shared: None,
        },
        set: ProductSet::Uniform(SetPart {
            size: now.gap.len(),
            set: AdmissibleSet::NonNegative,
        }),
        joint: None,
    }
}

/// Moves `state` by a whole step.
fn take_step(state: &mut State, iterate: QpIterate) {
    add_scaled(&mut state.displacement, 1.0, &iterate.displacement);
    if let [pressure, contact] = &iterate.blocks[..] {
        add_scaled(&mut state.pressure, 1.0, &pressure.multiplier);
        state.multiplier.clone_from(&contact.multiplier);
        state.status.clone_from(&contact.status);
    }
}
