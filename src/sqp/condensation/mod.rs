//! Increments of a linear body whose response at its contact surface is known: no Krylov
//! iteration, a small problem on the surface alone.
//!
//! ```text
//! K (u, p) = (f - C(u)^T l, 0)      u = u0 - G C(u)^T l on the surface,   G = R K^-1 R^T
//! g(u) >= 0,   l >= 0,   l g(u) = 0
//! ```
//!
//! K is factorised once ([`BodyFactor`]), u0 is the body under the loads and supports of the
//! drive without contact, R takes the unknowns of candidate faces. G comes column by column
//! where contact presses ([`columns`]); a sequence of dense cone problems with frozen normals
//! solves for l ([`surface_problem`]), one solution with the factor then gives all fields.
//! The state that follows is judged by the same residuals as any other, and the programs of
//! [`super::increment`] go on where they ask for it.
//!
//! For linear bodies that supports hold, without friction, pushed tools and pressures that
//! follow; the plan says from which step on ([`crate::plan::response`]). Everything kept is a
//! function of the body alone, or of loads and supports: bits do not depend on what was
//! kept. Cost: a factor, a pair of triangular solves a column, then some dense products an
//! update (L. Guyan, AIAA J. 3, 1965, for the condensation).

mod columns;
pub(crate) mod contact_alone;
mod free;
pub(crate) mod inside;
pub(super) mod kept;
mod known;
mod near;
mod surface_problem;

use std::sync::Arc;

use super::run::Run;
use crate::linalg::vector::{add_scaled, norm};
use crate::model::evaluate::Evaluation;
use crate::model::state::SurfaceLoad;
use kept::{Free, Response};
use known::{serves, with};
use surface_problem::SurfaceProblem;

constants! {
    /// Share of the force scale that may be left: more has another cause than rounding.
    const WORTHWHILE: f64 = 1e-2;
}

/// Moves the state, whose drive is the new one, to where contact holds, and says what holds
/// there; none where this is not the way for it. The increment begins with `plain` residuals and
/// that largest force, and with that load on the surface where it is known.
pub(crate) fn solve(
    run: &mut Run<'_>,
    plain: (&Evaluation, f64),
    known: Option<Arc<[f64]>>,
) -> Option<Evaluation> {
    let serves = serves(run, &run.state.drive);
    serves.then(|| with(run, |response, run| response.solve(run, plain, known)))?
}

impl Response {
    /// One increment; the state stays as it is where that brings nothing.
    fn solve(
        &mut self,
        run: &mut Run<'_>,
        (plain, first_force): (&Evaluation, f64),
        known: Option<Arc<[f64]>>,
    ) -> Option<Evaluation> {
        let free = self.free_under(run);
        let before = run.state.clone();
        // What programs would have seen on their way.
        let gap = plain.gap_norm(run.state);
        run.state.scales.see(0.0, gap);
        let problem = SurfaceProblem {
            body: &self.body,
            near: &mut self.near,
            free: &free,
        };
        let start = std::time::Instant::now();
        let solved = problem.solve(run, (plain.clone(), known));
        run.counters.seconds.contact += start.elapsed().as_secs_f64();
        let now = solved.and_then(|at| {
            run.state.multiplier = at.state.multiplier;
            run.state.status = at.state.status;
            let start = std::time::Instant::now();
            let force = first_force.max(norm(&at.load));
            run.state.scales.see(self.body.volumes * force, 0.0);
            run.state.surface_load = Some(SurfaceLoad {
                load: at.load.as_slice().into(),
                is_whole: true,
            });
            self.fill_fields(run, &free, at.load);
            run.counters.seconds.krylov += start.elapsed().as_secs_f64();
            let now = run.evaluate();
            let bound = WORTHWHILE * now.force_scale(first_force);
            (norm(&now.force) <= bound).then_some(now)
        });
        if now.is_none() {
            *run.state = before;
        }
        self.free = Some(free);
        now
    }

    /// Displacement and pressure under the contact load `[displacement]`.
    fn fill_fields(&self, run: &mut Run<'_>, free: &Free, load: Vec<f64>) {
        let solution = self.body.solution(load, run.work);
        let (moved, pressure) = solution.split_at(free.displacement.len());
        run.state.displacement.clone_from(&free.displacement);
        run.state.pressure.clone_from(&free.pressure);
        add_scaled(&mut run.state.displacement, -1.0, moved);
        add_scaled(&mut run.state.pressure, -1.0, pressure);
    }
}

/// The numeric constants of this room.
pub(crate) fn constants() -> Vec<crate::constants::Constant> {
    [
        columns::own_constants(),
        free::own_constants(),
        near::own_constants(),
        own_constants(),
        surface_problem::own_constants(),
    ]
    .concat()
}
