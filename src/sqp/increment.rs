//! Solves for equilibrium under one drive by sequential quadratic programs.
//!
//! Each program freezes the normals, keeps the curvature of the gap as a term
//! of the stiffness, and is solved to a fraction of the present residual. A
//! linear body before a flat obstacle needs one program. Supports of a linear
//! body jump to where they shall be; those of rubber move with the step, so that
//! the body follows and no element is turned inside out beside them.

use super::condensation::{self, inside};
use super::predictor;
use super::program::{QuadraticProgram, Step};
use super::run::Run;
use super::scales::{
    forget_scales, is_rounding, least_force, limit_gap_scale, raise_scales, touches,
};
use super::search::{Refused, non_monotone_step, search};
use super::verdict::{Verdict, of_status, verdict};
use crate::linalg::vector::norm;
use crate::model::carry::carry;
use crate::model::drive::Drive;
use crate::model::ending::Ending;
use crate::model::evaluate::Evaluation;
use crate::model::prescribed::{prescribe, remaining_motion};
use crate::model::state::State;
use crate::report::{Cause, Residuals, Termination};

constants! {
    /// Programs of a linear problem that may leave the residual as it is: rounding does.
    const MOST_IDLE: u32 = 5;
    /// Residual up to which a linear problem is solved whose rounding hides the rest: by 1e12 between
    /// moduli 1e-4 are hidden, and forces still are right to 1e-6.
    const MOST_ROUNDING: f64 = 1e-3;
    /// The same of a body of finite strain, which turns against forces that grow before they fall: a
    /// bonded block of 32 cells ends at the same load after 12 s with this and after 27 to 35 s without.
    const MOST_IDLE_AT_FINITE_STRAIN: u32 = 12;
    /// Steps of an increment that are taken without progress.
    const MOST_NON_MONOTONE: u32 = 3;
    /// Level of a program over the tolerance: what the recomputed residual adds has room.
    const MARGIN: f64 = 0.95;
    /// The level over that of a program that took no iteration though the state was not solved: a press
    /// that comes back to just touch takes 8 programs with it, 13 without.
    const SHARPER: f64 = 0.3;
    /// First reduction asked of a program with a curved gap.
    const FIRST_REDUCTION: f64 = 1e-2;
}

/// Where the programs of an increment have come to.
struct Iterate {
    /// Residuals at the present state.
    now: Evaluation,
    /// Largest force out of balance that the increment began with: a scale.
    first_force: f64,
    /// Constraint violation and force residual where programs began.
    filter: Vec<[f64; 2]>,
    /// Share of the residual that the next program may leave.
    reduction: f64,
    /// Level over the tolerance below which no program need go.
    margin: f64,
    /// Least residual of a linear problem so far.
    least: f64,
    /// Programs since that have not halved it.
    idle: u32,
    /// Steps that were taken without progress.
    non_monotone_steps: u32,
}

/// Moves the state to equilibrium under `drive`.
pub(crate) fn solve(run: &mut Run<'_>, drive: &Drive) -> Ending {
    let mut at = start(run, drive);
    for _ in 0..run.model.conditions.programs {
        let motion = remaining_motion(&run.model, run.state, drive);
        let worst = at.residuals(run.state).largest();
        let ended = verdict(run, worst, motion.is_none());
        if let Some(verdict) = ended.or_else(|| at.idleness(run, worst)) {
            return at.ending(run, verdict);
        }
        run.state.surface_load = None;
        run.counters.sqp_iterations += 1;
        let mut program = QuadraticProgram::new(run, &at.now, motion, &mut at.first_force);
        let scale = program.force_scale();
        let worst = residuals(run.state, program.start(), scale).largest();
        let scales = run.state.scales;
        let (step, outcome) = at.solve_program(run, &mut program, worst);
        if let Some(verdict) = of_status(outcome, &run.watch) {
            // Those of a method that diverged would make a solution of any state.
            run.state.scales = scales.or(run.state.scales);
            // Where it has come to shows what has gone wrong.
            step.apply(run.state, 1.0);
            at.now = run.evaluate();
            return at.ending(run, verdict);
        }
        match search(
            run,
            &step,
            program.start(),
            (at.first_force, &mut at.filter),
        ) {
            Ok(next) => at.advance(run, next, worst),
            Err(refused) => match at.non_monotone_step(run, &step, program.start(), refused) {
                Some(next) => at.advance(run, next, worst),
                None => return at.ending(run, refused.verdict()),
            },
        }
    }
    at.ending(run, Verdict::failed(Cause::IterationLimit))
}

/// Moves the state to where the first program starts.
fn start(run: &mut Run<'_>, drive: &Drive) -> Iterate {
    forget_scales(run);
    let known = run.state.load_behind(drive);
    let (now, first_force) = if run.model.is_rubber() {
        predictor::start(run, drive)
    } else {
        let before = run.state.displacement.clone();
        prescribe(&run.model, drive, &mut run.state.displacement);
        // Where friction holds the body its way decides.
        let is_held = run.model.plan.has_friction() && touches(run.state);
        if !is_held {
            carry(&run.model, &before, &mut run.state.displacement);
        }
        run.state.drive = drive.clone();
        let now = run.evaluate();
        let force = norm(&now.force);
        (now, force)
    };
    limit_gap_scale(&run.model, run.state, &now);
    raise_scales(&run.model, run.state, &now);
    let first_force = first_force.max(least_force(&run.model, run.state, &now));
    Iterate {
        now: condensation::solve(run, (&now, first_force), known).unwrap_or(now),
        first_force,
        filter: Vec::new(),
        reduction: FIRST_REDUCTION,
        margin: MARGIN,
        least: f64::INFINITY,
        idle: 0,
        non_monotone_steps: 0,
    }
}

impl Iterate {
    /// Solves a program as far as its linearisation is worth, and notes what that cost.
    fn solve_program(
        &mut self,
        run: &mut Run<'_>,
        program: &mut QuadraticProgram<'_>,
        worst: f64,
    ) -> (Step, crate::inequality::QpStatus) {
        let share = if run.model.is_linear() {
            0.0
        } else {
            self.reduction
        };
        let goal = share * worst;
        let before = run.counters.applications;
        let (step, outcome) =
            program.solve(run, goal.max(self.margin * run.model.conditions.tolerance));
        let applications = run.counters.applications - before;
        if run.model.is_rubber() {
            let reached = goal.max(run.model.conditions.tolerance);
            run.learned.refresh.note(applications, worst, reached);
        }
        // What no iteration was spent on comes again as it is unless more is asked.
        self.margin = if applications == 0 {
            SHARPER * self.margin
        } else {
            MARGIN
        };
        (step, outcome.status)
    }

    /// Residuals after a step that brings no progress at once: slender bodies turn against forces
    /// far smaller than those that turning by a straight line wakes in them, and the next program
    /// takes these off (Chamberlain, Powell, Lemarechal and Pedersen, Math. Programming Study 16,
    /// 1982). None where it turns cells inside out, in linear bodies, in a proximal flow, whose steps are
    /// small enough, and too often.
    fn non_monotone_step(
        &mut self,
        run: &mut Run<'_>,
        step: &Step,
        now: &Evaluation,
        refused: Refused,
    ) -> Option<Evaluation> {
        let may_be_non_monotone = !run.model.is_linear() && run.model.conditions.proximal.is_none();
        let is_tried = refused == Refused::Progress && may_be_non_monotone;
        if !is_tried || self.non_monotone_steps >= MOST_NON_MONOTONE {
            return None;
        }
        self.non_monotone_steps += 1;
        non_monotone_step(run, step, now)
    }

    /// The four residuals at the present state; the state's scales grow with what they
    /// see.
    fn residuals(&self, state: &mut State) -> Residuals {
        residuals(state, &self.now, self.first_force)
    }

    /// The end of a linear problem whose programs are solved and bring nothing: what is
    /// left of its residual is rounding. Before that the kept
    /// directions go, whose products rounding has parted from them.
    fn idleness(&mut self, run: &mut Run<'_>, worst: f64) -> Option<Verdict> {
        if worst <= 0.5 * self.least {
            (self.least, self.idle) = (worst, 0);
            return None;
        }
        self.idle += 1;
        if !run.model.is_linear() {
            // By a factor every program is solved, whether it leads anywhere or not.
            let is_by_factor =
                run.learned.factored.is_some() && run.model.conditions.proximal.is_none();
            let is_stuck = is_by_factor && self.idle > MOST_IDLE_AT_FINITE_STRAIN;
            return is_stuck.then(|| Verdict::failed(Cause::Stagnation));
        }
        run.learned.directions.clear(run.work);
        (self.idle >= MOST_IDLE).then(|| self.end_of_progress(run))
    }

    /// How a linear problem ends whose programs are solved and bring nothing: in balance where what
    /// is left is rounding, and little of the forces. A body that no support holds slides away into
    /// a rounding of its own.
    fn end_of_progress(&self, run: &mut Run<'_>) -> Verdict {
        let left = self.residuals(run.state);
        let is_met = left.gap.max(left.complementarity) <= run.model.conditions.tolerance;
        let is_small = left.largest() <= MOST_ROUNDING && !run.model.plan.is_floating();
        if is_met && is_small && is_rounding(run, &self.now) {
            Verdict::stopped(Termination::Converged)
        } else {
            Verdict::failed(Cause::Stagnation)
        }
    }

    /// Takes an accepted step over, which started from the residual `worst`.
    fn advance(&mut self, run: &mut Run<'_>, next: Evaluation, worst: f64) {
        let before = std::mem::replace(&mut self.now, next);
        if let Some(advance) = before.advance.filter(|_| run.counters.step_length < 1.0) {
            let last = advance.last.clone();
            self.now
                .advance_from(last, (&run.model, run.state), run.work);
        }
        if run.model.is_rubber() {
            limit_gap_scale(&run.model, run.state, &self.now);
        }
        raise_scales(&run.model, run.state, &self.now);
        self.reduction = forcing(worst, self.residuals(run.state).largest());
    }

    /// The ending of the increment at the present state, for that verdict.
    fn ending(&self, run: &mut Run<'_>, verdict: Verdict) -> Ending {
        let at = (&self.now, self.first_force);
        ending(run.state, at, verdict, run.model.conditions.tolerance)
    }
}

/// The end of an increment at residuals `now`; notes the scale of the force residual,
/// of which `first_force` is one.
pub(crate) fn ending(
    state: &mut State,
    (now, first_force): (&Evaluation, f64),
    verdict: Verdict,
    tolerance: f64,
) -> Ending {
    state.force_scale = now.force_scale(first_force);
    Ending {
        termination: verdict.termination,
        cause: verdict.cause,
        residuals: residuals(state, now, first_force),
        max_penetration: now.max_penetration,
        force_scale: state.force_scale,
        tolerance,
        estimate: None,
        stability: None,
        snapped: None,
        site: None,
        alternative: None,
        leak: None,
    }
}

impl Refused {
    /// What a refused step means for the increment: a cause of failure.
    fn verdict(self) -> Verdict {
        Verdict::failed(match self {
            Self::Jacobian => Cause::NegativeJacobian,
            Self::Progress => Cause::LineSearch,
        })
    }
}

/// The end of an increment that is stopped between two of its parts.
pub(crate) fn stopped(run: &mut Run<'_>, termination: Termination) -> Ending {
    inside::complete(run);
    let (now, tolerance) = (run.evaluate(), run.model.conditions.tolerance);
    let at = (&now, run.state.force_scale);
    ending(run.state, at, Verdict::stopped(termination), tolerance)
}

/// The end of an increment that has taken as many steps as it may.
pub(crate) fn out_of_iterations(run: &mut Run<'_>) -> Ending {
    let (now, tolerance) = (run.evaluate(), run.model.conditions.tolerance);
    let at = (&now, run.state.force_scale);
    ending(
        run.state,
        at,
        Verdict::failed(Cause::IterationLimit),
        tolerance,
    )
}

/// Makes `ending` describe the state that is kept.
pub(crate) fn describe(run: &mut Run<'_>, ending: &mut Ending) {
    let run = &mut run.with_nothing_admitted();
    inside::complete(run);
    let now = run.evaluate();
    // That of the increment which led there.
    let known = run.state.force_scale;
    ending.force_scale = now.force_scale(known);
    ending.max_penetration = now.max_penetration;
    ending.residuals = residuals(run.state, &now, known);
}

/// Residuals, after the scales have seen the present norms.
pub(crate) fn residuals(state: &mut State, now: &Evaluation, first_force: f64) -> Residuals {
    let gap = now.gap_norm(state);
    state.scales.see(norm(&now.constraint), gap);
    now.residuals(state, first_force, &state.scales)
}

/// Eisenstat and Walker's second choice: the better the last program predicted,
/// the more is asked of the next.
fn forcing(before: f64, after: f64) -> f64 {
    (0.5 * (after / before).powi(2)).clamp(1e-6, FIRST_REDUCTION)
}
