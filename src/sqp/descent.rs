//! Down the energy from an equilibrium that is lost to the next minimum, as a body with a
//! little viscosity goes:
//!
//! ```text
//! u_k+1 = argmin E(u) + t_k / 2 (u - u_k).M (u - u_k)   with volume and contact
//! ```
//!
//! ([`crate::model::proximal`]). t begins at some multiples of what the softest motion lacks
//! in stiffness, so that every step is a stable problem; it halves where steps are solved
//! and grows where they are not. A push along the softest motion, to the side that the body
//! leans to already, leaves a symmetric saddle. Where the motion ebbs away the equilibrium
//! without the pull is solved and certified. The energy that is lost is the work of the
//! pull, which counts loads without a potential, too. Cost: some ten to thirty steps of two
//! to four programs each.

use std::sync::Arc;

use super::attempt::attempt;
use super::increment;
use super::lowest_mode::{LowestMode, at_rest};
use super::run::Run;
use crate::linalg::vector::{add_scaled, dot};
use crate::model::conditions::Conditions;
use crate::model::drive::Drive;
use crate::model::ending::{Ending, Snap};
use crate::model::proximal::{Proximal, mass};
use crate::model::state::State;
use crate::report::{Cause, Termination};

/// Steps at most.
const MOST_STEPS: u32 = 80;
/// Failures one after the other that end the way.
const MOST_FAILURES: u32 = 5;
/// Programs that a step, or the end where it is tried, may take: where they are more a
/// program leads anywhere.
const PATIENCE: u32 = 8;
/// The same behind a step that failed: slender bodies turn far with little force, and programs
/// go there by small parts.
const MORE_PATIENCE: u32 = 24;
/// Residuals that a step may leave.
const ROUGH: f64 = 1e-3;
/// Share of what moves the body that a step may leave.
const REDUCTION: f64 = 0.05;
/// Largest motion of the first push, over the body's length.
const PUSH: f64 = 5e-3;
/// First weight over what the softest motion lacks, and beside it over its stiffness at
/// rest.
const FIRST_WEIGHT: [f64; 2] = [4.0, 0.2];
/// Least weight behind a saddle over the first.
const LEAST_WEIGHT: f64 = 0.4;
/// Change of the least weight behind a step that pulls more than all before.
const RECEDING: f64 = 0.8;
/// Change of the weight behind a step that was solved, and one that was not.
const CHANGE: [f64; 2] = [0.5, 4.0];
/// Steps with one pull behind a failure.
const REST: u32 = 4;
/// Share of the strongest force at which the end is tried, and of the last that was tried.
const EBB: f64 = 0.2;

/// A way down.
struct Flow {
    /// M `[displacement]`.
    mass: Arc<[f64]>,
    /// t, non-dimensional.
    weight: f64,
    /// t times the length of the step where that was most, or of the last one behind which
    /// the end was tried: the force that moves the body.
    strongest: f64,
    /// t M times the last step `[displacement]`: the force that moved the body at its end.
    pull: Vec<f64>,
    /// Work of that force since the start.
    lost: f64,
    /// Failures one after the other.
    failures: u32,
    /// Steps until the pull may become lighter.
    rest: u32,
    /// Least t: with less a step near the saddle that was left leads back to it.
    least: f64,
    /// Programs that a step, or the end, may take.
    programs: u32,
    /// Whether the next step is the first behind a push, which mends what that has torn.
    is_first: bool,
}

/// Moves the state, a minimum, down to one under `drive`, and says what was lost on the
/// way; none where there is no such way. What stops it from outside ends it, too.
pub(super) fn descend(run: &mut Run<'_>, drive: &Drive) -> Option<Ending> {
    let before = run.state.displacement.clone();
    let mut flow = Flow::new(run);
    run.learned.trend = None;
    push(run);
    for _ in 0..MOST_STEPS {
        let kept = run.state.clone();
        let ending = flow.step(run, drive);
        if ending.is_stopped() {
            return Some(ending);
        }
        if ending.termination != Termination::Converged {
            if run.is_spent() {
                return None;
            }
            run.state.clone_from(&kept);
            flow.fail();
            if flow.failures > MOST_FAILURES {
                return None;
            }
            continue;
        }
        let ebbs = flow.ebbs(&kept, run.state);
        flow.succeed();
        if !ebbs {
            continue;
        }
        let kept = run.state.clone();
        // The factor of a step holds the pull.
        run.learned.factored = None;
        let mut ending = attempt(&mut run.under(flow.conditions(run)), drive);
        if ending.termination == Termination::Converged {
            flow.add_work(&[&kept.displacement, &run.state.displacement], 0.0);
            ending.snapped = Some(flow.snap(run, &before));
            return Some(ending);
        }
        if ending.is_stopped() {
            return Some(ending);
        }
        match ending.cause {
            // A well of the mesh, not of the body.
            Some(Cause::InsideOut) => return None,
            Some(Cause::UnstableEquilibrium) => flow.leave_saddle(run),
            _ => run.state.clone_from(&kept),
        }
    }
    None
}

impl Flow {
    /// From the present state.
    fn new(run: &Run<'_>) -> Self {
        let mass = mass(&run.model);
        Self {
            weight: first_weight(run, &mass),
            mass: mass.into(),
            strongest: 0.0,
            pull: vec![0.0; run.state.displacement.len()],
            lost: 0.0,
            failures: 0,
            rest: 0,
            least: 0.0,
            programs: PATIENCE,
            is_first: true,
        }
    }

    /// Starts anew from the present state, a saddle.
    fn leave_saddle(&mut self, run: &mut Run<'_>) {
        self.weight = first_weight(run, &self.mass);
        self.pull.fill(0.0);
        self.strongest = 0.0;
        self.least = LEAST_WEIGHT * self.weight;
        self.is_first = true;
        push(run);
    }

    /// Those of the end, with few programs: where they are more a program leads anywhere.
    fn conditions(&self, run: &Run<'_>) -> Conditions {
        Conditions {
            programs: self.programs,
            ..run.model.conditions.clone()
        }
    }

    /// One step.
    fn step(&mut self, run: &mut Run<'_>, drive: &Drive) -> Ending {
        let tolerance = run.model.conditions.tolerance;
        let before: Arc<[f64]> = run.state.displacement.clone().into();
        let run = &mut run.under(Conditions {
            proximal: Some(Proximal {
                weight: self.weight,
                anchor: before.clone(),
                mass: self.mass.clone(),
            }),
            ..self.conditions(run)
        });
        let pulled = run.evaluate();
        let residual = increment::residuals(run.state, &pulled, 0.0).equilibrium;
        let level = (REDUCTION * residual).clamp(tolerance, ROUGH.max(tolerance));
        let ending = increment::solve(&mut run.to(level), drive);
        if ending.termination == Termination::Converged {
            self.add_work(&[&before, &run.state.displacement], self.weight);
        }
        ending
    }

    /// Adds the work on the way between two displacements, at whose end the pull has that
    /// weight: its mean times the way.
    fn add_work(&mut self, [from, to]: &[&[f64]; 2], weight: f64) {
        let ways = from.iter().zip(*to).map(|(from, to)| to - from);
        for ((way, mass), pull) in ways.zip(&*self.mass).zip(&mut self.pull) {
            let before = std::mem::replace(pull, weight * mass * way);
            self.lost += 0.5 * (before + *pull) * way;
        }
    }

    /// Takes a heavier pull for a while.
    fn fail(&mut self) {
        self.failures += 1;
        self.programs = MORE_PATIENCE;
        self.weight *= CHANGE[1];
        self.rest = REST;
    }

    /// Takes a lighter pull unless one has just failed.
    fn succeed(&mut self) {
        self.failures = 0;
        match self.rest {
            0 => self.weight = self.least.max(CHANGE[0] * self.weight),
            _ => self.rest -= 1,
        }
    }

    /// Whether what moves the body is weak beside what did, so that the end may be near.
    fn ebbs(&mut self, before: &State, after: &State) -> bool {
        let ends = before.displacement.iter().zip(&after.displacement);
        let squares = ends.zip(&*self.mass).map(|((a, b), m)| m * (b - a).powi(2));
        if std::mem::replace(&mut self.is_first, false) {
            return false;
        }
        let pull = self.weight * squares.sum::<f64>().sqrt();
        let ebbs = pull <= EBB * self.strongest;
        // The saddle is the farther behind the longer the pull has grown.
        if pull > self.strongest {
            self.least *= RECEDING;
        }
        self.strongest = match ebbs {
            true => pull,
            false => self.strongest.max(pull),
        };
        ebbs
    }

    /// What the way from `before` to the present state was.
    fn snap(&self, run: &Run<'_>, before: &[f64]) -> Snap {
        let space = &run.model.prepared.space;
        let c = space.components;
        let motion = |vertex: usize| {
            let own = vertex * c..(vertex + 1) * c;
            let ends = before[own.clone()].iter().zip(&run.state.displacement[own]);
            ends.map(|(a, b)| (b - a).powi(2)).sum::<f64>().sqrt()
        };
        let vertices = (0..space.vertices).map(|vertex| (motion(vertex), vertex));
        let (largest_motion, vertex) = vertices
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or_default();
        Snap {
            energy_drop: self.lost,
            largest_motion,
            point: run.model.mesh.coordinates()[vertex],
            was_lost: true,
        }
    }
}

/// The weight that makes the softest motion stable, if it is known.
fn first_weight(run: &Run<'_>, mass: &[f64]) -> f64 {
    let Some(mode) = &run.learned.lowest_mode else {
        return 1.0;
    };
    let squares = mode.motion.iter().zip(mass).map(|(x, m)| m * x * x);
    let inertia: f64 = squares.sum();
    (FIRST_WEIGHT[0] * mode.eigenvalue.abs() + FIRST_WEIGHT[1]) / inertia
}

/// Moves the state along the softest motion, if it is known, to the side that it leans to.
fn push(run: &mut Run<'_>) {
    let Some(LowestMode { motion, .. }) = run.learned.lowest_mode.clone() else {
        return;
    };
    let largest = motion.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let leaning = at_rest(&run.model, &motion, &mut run.work);
    let side = dot(&leaning, &run.state.displacement);
    let length = PUSH / largest * if side < 0.0 { -1.0 } else { 1.0 };
    add_scaled(&mut run.state.displacement, length, &motion);
}
