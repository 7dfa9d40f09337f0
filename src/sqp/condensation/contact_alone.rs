//! Answers on contact alone, for scenes whose reports leave the body inside out: the surface is
//! moved by the columns that press, and no solution with the factor follows.
//!
//! ```text
//! equilibrium     (|C(u)^T l - q| + a |q| + a0) / load
//! volumes         (b |q| + b0) / their scale
//! ```
//!
//! q the load that moved the surface; a, b what a solution with the factor leaves of a load,
//! measured once; a0, b0 what u0 leaves, measured. Gap and complementarity are those of the
//! surface, as everywhere. An answer that these do not show to be within the tolerance is given
//! up for one on the whole body, and each [`WHOLE_EVERY`]th step is one anyway, its residuals
//! measured. The load is kept with the state: what the body does inside follows from it when it is
//! asked for ([`super::inside`]). Cost: that of the surface problem.

use super::inside;
use super::kept::Response;
use super::known::{serves, with};
use super::surface_problem::{Iterate, SurfaceProblem, pressing};
use crate::linalg::vector::{norm, ratio};
use crate::model::carry::carry;
use crate::model::counters::timed;
use crate::model::drive::Drive;
use crate::model::ending::Ending;
use crate::model::evaluate::{Evaluation, evaluate_contact, load_norm};
use crate::model::prescribed::prescribe;
use crate::model::state::SurfaceLoad;
use crate::report::{Residuals, Termination};
use crate::scene::ReportScope;
use crate::sqp::increment;
use crate::sqp::run::Run;
use crate::sqp::scales::{forget_scales, limit_gap_scale, raise_scales};
use crate::sqp::verdict::Verdict;

constants! {
    /// Steps of which one is answered on the whole body.
    const WHOLE_EVERY: u32 = 64;
}

/// Moves the state to where contact holds under `drive`, the body inside left behind; none, and
/// the state whole and where it was, where this is not the way for it.
pub(crate) fn answer(run: &mut Run<'_>, drive: &Drive) -> Option<Ending> {
    let ending = if is_enough(run, drive) {
        with(run, |response, run| response.answer(run, drive))
    } else {
        None
    };
    if ending.is_none() {
        inside::complete(run);
    }
    ending
}

/// Whether contact is all that the increment has to tell of.
fn is_enough(run: &Run<'_>, drive: &Drive) -> bool {
    let is_asked = run.model.plan.problem.settings.report == ReportScope::Contact;
    let is_due = !run.watch.record.step.is_multiple_of(WHOLE_EVERY);
    is_asked && is_due && serves(run, drive)
}

impl Response {
    /// One increment; the state stays as it is where that is not within the tolerance.
    fn answer(&mut self, run: &mut Run<'_>, drive: &Drive) -> Option<Ending> {
        let before = run.state.clone();
        let known = run.state.load_behind(drive);
        let plain = begin(run, drive);
        let free = self.free_under(run);
        let problem = SurfaceProblem {
            body: &self.body,
            near: &mut self.near,
            free: &free,
        };
        let start = std::time::Instant::now();
        let solved = problem.solve(run, (plain, known));
        run.counters.seconds.contact += start.elapsed().as_secs_f64();
        self.free = Some(free);
        let ending = solved.and_then(|at| self.judged(run, at));
        if ending.is_none() {
            *run.state = before;
        }
        ending
    }

    /// Takes the surface over into the state; none where it is not within the tolerance.
    fn judged(&self, run: &mut Run<'_>, mut at: Iterate) -> Option<Ending> {
        let free = self.free.as_ref()?;
        let mut wrong = pressing(&at.now, &at.state, run.work);
        at.now.contact_norm = norm(&wrong);
        at.now.load_norm = load_norm(&run.model, run.state);
        at.now.reaction_norm = free.reaction_norm;
        (wrong.iter_mut().zip(&at.load)).for_each(|(wrong, q)| *wrong -= q);
        let load = norm(&at.load);
        let state = &mut *run.state;
        state.displacement = at.state.displacement;
        state.multiplier = at.state.multiplier;
        state.status = at.state.status;
        state.surface_load = Some(SurfaceLoad {
            load: at.load.into(),
            is_whole: false,
        });
        state.scales.see(self.body.volumes * load, 0.0);
        let verdict = Verdict::stopped(Termination::Converged);
        let mut ending = increment::ending(
            state,
            (&at.now, 0.0),
            verdict,
            run.model.conditions.tolerance,
        );
        let force = norm(&wrong) + self.body.accuracy.force * load + free.left.force;
        let volume = self.body.accuracy.volume * load + free.left.volume;
        ending.residuals = Residuals {
            equilibrium: ratio(force, ending.force_scale),
            incompressibility: ratio(volume, state.scales.constraint),
            ..ending.residuals
        };
        (ending.residuals.largest() <= run.model.conditions.tolerance).then_some(ending)
    }
}

/// Drives the state, and says what contact does there; scales forget what has passed.
fn begin(run: &mut Run<'_>, drive: &Drive) -> Evaluation {
    forget_scales(run);
    let held = run.state.displacement.clone();
    prescribe(&run.model, drive, &mut run.state.displacement);
    carry(&run.model, &held, &mut run.state.displacement);
    run.state.drive = drive.clone();
    let mut plain = timed(&mut run.counters.seconds.contact, || {
        evaluate_contact(&run.model, run.state)
    });
    plain.load_norm = load_norm(&run.model, run.state);
    limit_gap_scale(&run.model, run.state, &plain);
    raise_scales(&run.model, run.state, &plain);
    let gap = plain.gap_norm(run.state);
    run.state.scales.see(0.0, gap);
    plain
}
