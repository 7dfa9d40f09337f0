//! Snap-through: down the energy from an equilibrium that is lost to the next minimum, by a
//! [flow](crate::sqp::proximal_flow),
//!
//! ```text
//! u_k+1 = argmin E(u) + t_k / 2 (u - u_k).M (u - u_k)   with volume and contact
//! ```
//!
//! t begins at some multiples of what the softest motion lacks in stiffness, so that every step is
//! a stable problem; it halves where steps are solved and grows where they are not. A push along
//! the softest motion, to the side that the body leans to already, leaves a symmetric saddle. Where
//! the flow ebbs away the equilibrium without its force is solved and certified. The energy that is
//! lost is the work of that force, which counts loads without a potential, too. Cost: some ten to
//! thirty steps of two to four programs each.

use super::part::solve_part;
use crate::linalg::vector::{add_scaled, dot};
use crate::model::conditions::Conditions;
use crate::model::drive::Drive;
use crate::model::ending::{Ending, Snap};
use crate::model::state::State;
use crate::report::{Cause, Termination};
use crate::sqp::increment;
use crate::sqp::lowest_mode::{LowestMode, at_rest};
use crate::sqp::proximal_flow::{Advance, End, Flow, Limits, Policy};
use crate::sqp::run::Run;

constants! {
    /// Programs that a step, or the end where it is tried, may take: where they are more a
    /// program leads anywhere.
    const PATIENCE: u32 = 8;
    /// The same after a step that failed: slender bodies turn far with little force, and programs
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
    /// Least weight after a saddle over the first.
    const LEAST_WEIGHT: f64 = 0.4;
    /// Change of the least weight after a step with a larger force than all before.
    const RECEDING: f64 = 0.8;
    /// Steps at most.
    const MOST_STEPS: u32 = 80;
    /// Failures one after the other that end the flow.
    const MOST_FAILURES: u32 = 6;
    /// Change of the weight after a step that was not solved.
    const HEAVIER: f64 = 4.0;
    /// Change of the weight after a step that was solved.
    const LIGHTER: f64 = 0.5;
    /// Steps with one weight after a failure.
    const REST: u32 = 4;
    /// Share of the strongest force at which the end is tried, and of the last that was tried.
    const EBB: f64 = 0.2;
}

/// Moves the state, a minimum, down to one under `drive`, and says what was lost on the way; the
/// state is of no use where that does not converge.
pub(super) fn snap_through(run: &mut Run<'_>, drive: &Drive) -> Ending {
    let before = run.state.displacement.clone();
    let flow = Flow::new(run, |mass| first_weight(run, mass));
    let mut policy = SnapThrough::from(before);
    run.learned.trend = None;
    push(run);
    flow.follow(run, drive, &mut policy)
}

/// A flow down the energy.
struct SnapThrough {
    /// Where it began `[displacement]`.
    start: Vec<f64>,
    /// t times the length of the step where that was most, or of the last one after which
    /// the end was tried: the force that moves the body.
    strongest: f64,
    /// t M times the last step `[displacement]`: the force that moved the body at its end.
    force: Vec<f64>,
    /// Work of that force since the start.
    lost: f64,
    /// Steps until t may become lighter.
    rest: u32,
    /// Least t: with less a step near the saddle that was left leads back to it.
    least: f64,
    /// Programs that a step, or the end, may take.
    programs: u32,
    /// Whether the next step is the first after a push, which mends what that has torn.
    is_first: bool,
}

impl Policy for SnapThrough {
    const LIMITS: Limits = Limits {
        steps: MOST_STEPS,
        failures: MOST_FAILURES,
        heavier: HEAVIER,
    };

    fn conditions(&mut self, run: &mut Run<'_>) -> Conditions {
        let now = run.evaluate();
        let residual = increment::residuals(run.state, &now, 0.0).equilibrium;
        let conditions = self.with_few_programs(run);
        let tolerance = conditions.tolerance;
        Conditions {
            tolerance: (REDUCTION * residual).clamp(tolerance, ROUGH.max(tolerance)),
            ..conditions
        }
    }

    fn fail(&mut self, run: &Run<'_>, _: &mut Ending) -> bool {
        self.rest = REST;
        self.programs = MORE_PATIENCE;
        run.is_spent()
    }

    fn advance(&mut self, run: &mut Run<'_>, flow: &mut Flow, before: &State) -> Advance {
        let ends = [&before.displacement[..], &run.state.displacement];
        self.add_work(ends, flow);
        let ebbs = self.ebbs(ends, flow);
        match self.rest {
            0 => flow.weight = self.least.max(LIGHTER * flow.weight),
            _ => self.rest -= 1,
        }
        if ebbs { Advance::End } else { Advance::Step }
    }

    fn end(&mut self, run: &mut Run<'_>, flow: &mut Flow, drive: &Drive) -> End {
        let before = run.state.displacement.clone();
        // The factor of a step holds its proximal term.
        run.learned.factored = None;
        let mut ending = solve_part(&mut run.under(self.with_few_programs(run)), drive);
        if ending.termination == Termination::Converged {
            // The last force fades away.
            flow.weight = 0.0;
            self.add_work([&before, &run.state.displacement], flow);
            ending.snapped = Some(self.snap(run));
        }
        match ending.cause {
            _ if ending.termination != Termination::NotConverged => End::At(ending.into()),
            // A well of the mesh, not of the body; nothing holds what a fluid passes.
            Some(Cause::InsideOut | Cause::Leaks) => End::At(ending.into()),
            Some(Cause::UnstableEquilibrium) => {
                self.leave_saddle(run, flow);
                End::Elsewhere
            }
            _ => End::NotYet,
        }
    }
}

impl SnapThrough {
    /// From that displacement.
    fn from(start: Vec<f64>) -> Self {
        Self {
            strongest: 0.0,
            force: vec![0.0; start.len()],
            lost: 0.0,
            rest: 0,
            least: 0.0,
            programs: PATIENCE,
            is_first: true,
            start,
        }
    }

    /// Those of `run`, with few programs.
    fn with_few_programs(&self, run: &Run<'_>) -> Conditions {
        Conditions {
            programs: self.programs,
            ..run.model.conditions.clone()
        }
    }

    /// Starts anew from the present state, a saddle.
    fn leave_saddle(&mut self, run: &mut Run<'_>, flow: &mut Flow) {
        flow.weight = first_weight(run, &flow.mass);
        self.force.fill(0.0);
        self.strongest = 0.0;
        self.least = LEAST_WEIGHT * flow.weight;
        self.is_first = true;
        push(run);
    }

    /// Adds the work on the way between two displacements: the mean of the forces at its ends
    /// times the way.
    fn add_work(&mut self, [from, to]: [&[f64]; 2], flow: &Flow) {
        let ways = from.iter().zip(to).map(|(from, to)| to - from);
        for ((way, mass), force) in ways.zip(&*flow.mass).zip(&mut self.force) {
            let before = std::mem::replace(force, flow.weight * mass * way);
            self.lost += 0.5 * (before + *force) * way;
        }
    }

    /// Whether what moves the body is weak beside what did, so that the end may be near.
    fn ebbs(&mut self, [from, to]: [&[f64]; 2], flow: &Flow) -> bool {
        let squares = from.iter().zip(to).zip(&*flow.mass);
        let square: f64 = squares.map(|((a, b), m)| m * (b - a).powi(2)).sum();
        if std::mem::replace(&mut self.is_first, false) {
            return false;
        }
        let force = flow.weight * square.sqrt();
        let ebbs = force <= EBB * self.strongest;
        // The saddle is the farther away the larger the force has grown.
        if force > self.strongest {
            self.least *= RECEDING;
        }
        self.strongest = if ebbs {
            force
        } else {
            self.strongest.max(force)
        };
        ebbs
    }

    /// What the way from the start to the present state was.
    fn snap(&self, run: &Run<'_>) -> Snap {
        let space = &run.model.prepared.space;
        let c = space.components;
        let motion = |vertex: usize| {
            let own = vertex * c..(vertex + 1) * c;
            let ends = self.start[own.clone()]
                .iter()
                .zip(&run.state.displacement[own]);
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
    let leaning = at_rest(&run.model, &motion, run.work);
    let side = dot(&leaning, &run.state.displacement);
    let length = PUSH / largest * if side < 0.0 { -1.0 } else { 1.0 };
    add_scaled(&mut run.state.displacement, length, &motion);
}
