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
//! The state behind is judged by the same residuals as any other, and the programs of
//! [`super::increment`] go on where they ask for it.
//!
//! For linear bodies that supports hold, without friction, pushed tools and pressures that
//! follow; the plan says from which step on ([`crate::plan::response`]). Everything kept is a
//! function of the body alone, or of loads and supports: bits do not depend on what was
//! kept. Cost: a factor, a pair of triangular solves a column, then some dense products an
//! update (L. Guyan, AIAA J. 3, 1965, for the condensation).

mod columns;
mod free;
pub(super) mod kept;
mod surface_problem;

use super::run::Run;
use crate::inequality::{BodyFactor, Matrices};
use crate::linalg::vector::{add_scaled, norm};
use crate::linalg::{LinearOperator, SparseRowsBuilder, Workspace};
use crate::model::Model;
use crate::model::evaluate::Evaluation;
use crate::plan::estimate::MOST_RESPONSE_FLOPS;
use crate::plan::response::FieldsFrom;
use columns::Columns;
use kept::{Free, Known, Response};
use surface_problem::SurfaceProblem;

/// Share of the force scale that may be left: more has another cause than rounding.
const WORTHWHILE: f64 = 1e-2;

/// Moves the state, whose drive is the new one, to where contact holds, and says what holds
/// there; none where this is not the way for it. The increment begins with `plain` residuals and
/// that largest force.
pub(crate) fn solve(run: &mut Run<'_>, plain: (&Evaluation, f64)) -> Option<Evaluation> {
    if !serves(run) {
        return None;
    }
    let mut known = std::mem::take(&mut run.learned.response);
    if matches!(known, Known::Nothing) {
        known = known_now(run);
    }
    let solved = match &mut known {
        Known::Response(response) => response.solve(run, plain),
        Known::Nothing | Known::Refused => None,
    };
    run.learned.response = known;
    solved
}

/// Whether the increment is one for it.
fn serves(run: &Run<'_>) -> bool {
    let step = run.watch.record.step;
    let is_due = (run.model.plan.response.from).is_some_and(|from| step >= from);
    is_due && run.state.drive.pushes.is_empty() && run.model.proximal.is_none()
}

/// The response, made now.
fn known_now(run: &mut Run<'_>) -> Known {
    let start = std::time::Instant::now();
    let places = run.learned.layout(&run.model).places.clone();
    let factor = factor(run);
    run.counters.seconds.factorise += start.elapsed().as_secs_f64();
    match factor {
        Some(factor) => {
            run.counters.factorisations += 1;
            let unknowns = surface_unknowns(&run.model);
            Known::Response(Box::new(Response {
                volumes: volumes(&run.model, &unknowns, &mut run.work),
                columns: Columns::new(unknowns, &places, run.model.plan.response.fields),
                factor,
                free: None,
            }))
        }
        None if run.stopped().is_some() => Known::Nothing,
        None => Known::Refused,
    }
}

/// K as a factor; none where it does not fit, or the increment is stopped.
fn factor(run: &mut Run<'_>) -> Option<BodyFactor> {
    let layout = run.learned.layout(&run.model);
    let Run {
        model,
        watch,
        counters,
        work,
        ..
    } = run;
    let stopped = || watch.stopped(counters).is_some();
    let space = &model.prepared.space;
    let no_contact = SparseRowsBuilder::new(space.displacement_unknowns()).finish();
    let block = model.prepared.pressure.as_ref();
    let operators = (
        &model.prepared.stiffness as &dyn LinearOperator,
        block.map(|block| &block.coupling as &dyn LinearOperator),
    );
    let (stiffness, coupling) = layout.stored(operators, &stopped, work)?;
    let matrices = Matrices {
        stiffness,
        coupling,
        stabilisation: block.and_then(|block| block.stabilisation.as_ref()),
        contact: &no_contact,
        places: layout.places.clone(),
        is_loose: false,
        may_be_indefinite: false,
        most_flops: MOST_RESPONSE_FLOPS,
    };
    BodyFactor::new(&matrices).ok()
}

impl Response {
    /// One increment; the state stays as it is where that brings nothing.
    fn solve(
        &mut self,
        run: &mut Run<'_>,
        (plain, first_force): (&Evaluation, f64),
    ) -> Option<Evaluation> {
        let free = match self.free.take() {
            Some(free) if free.is_of(&run.state.drive) => free,
            Some(_) | None => free::free(run, &self.factor),
        };
        let before = run.state.clone();
        // What programs would have seen on their way.
        let gap = plain.gap_norm(run.state);
        run.state.scales.see(0.0, gap);
        let problem = SurfaceProblem {
            columns: &mut self.columns,
            factor: &self.factor,
            free: &free,
        };
        let start = std::time::Instant::now();
        let load = problem.solve(run, plain);
        run.counters.seconds.contact += start.elapsed().as_secs_f64();
        let now = load.and_then(|load| {
            let start = std::time::Instant::now();
            let force = first_force.max(norm(&load));
            run.state.scales.see(self.volumes * force, 0.0);
            self.fill_fields(run, &free, load);
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
    fn fill_fields(&mut self, run: &mut Run<'_>, free: &Free, load: Vec<f64>) {
        let solution = self.solution(load, &mut run.work);
        let (moved, pressure) = solution.split_at(free.displacement.len());
        run.state.displacement.clone_from(&free.displacement);
        run.state.pressure.clone_from(&free.pressure);
        add_scaled(&mut run.state.displacement, -1.0, moved);
        add_scaled(&mut run.state.pressure, -1.0, pressure);
    }

    /// K^-1 of a load on the surface `[displacement]`, in the same way whatever is known.
    fn solution(&mut self, mut load: Vec<f64>, work: &mut Workspace) -> Vec<f64> {
        load.resize(self.factor.size(), 0.0);
        match self.columns.fields {
            FieldsFrom::Columns => self.columns.whole_product(&load, &self.factor),
            FieldsFrom::Factor => {
                self.factor.solve(&mut load, work);
                load
            }
        }
    }
}

/// |B A^ r| / |r| for a load of one on each of `unknowns`; zero in displacement form.
fn volumes(model: &Model<'_>, unknowns: &[u32], work: &mut Workspace) -> f64 {
    let Some(block) = &model.prepared.pressure else {
        return 0.0;
    };
    let size = model.prepared.space.displacement_unknowns();
    let (mut load, mut moved) = (work.zeros(size), work.zeros(size));
    (unknowns.iter()).for_each(|&unknown| load[unknown as usize] = 1.0);
    let inverse = &model.prepared.at_rest.displacement;
    inverse.apply(&load, &mut moved, work);
    let mut changed = vec![0.0; block.coupling.rows()];
    block.coupling.apply(&moved, &mut changed, work);
    let ratio = norm(&changed) / norm(&load).max(f64::MIN_POSITIVE);
    work.give(load);
    work.give(moved);
    ratio
}

/// Free unknowns of candidate faces, ascending.
fn surface_unknowns(model: &Model<'_>) -> Vec<u32> {
    let space = &model.prepared.space;
    let c = space.components as u32;
    let faces = model.interfaces.list.iter();
    let nodes = faces.flat_map(|one| one.surface.faces.iter().flat_map(|face| &face.nodes));
    let mut unknowns: Vec<u32> = nodes.flat_map(|&node| node * c..(node + 1) * c).collect();
    unknowns.sort_unstable();
    unknowns.dedup();
    unknowns.retain(|&unknown| !model.prepared.is_held[unknown as usize]);
    unknowns
}
