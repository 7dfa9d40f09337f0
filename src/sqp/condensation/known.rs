//! The response of a body, made where no session of it has one. Cost: a factor.

use std::sync::Arc;

use super::columns::Columns;
use super::kept::{Accuracy, BodyResponse, Known, Response};
use super::near::Near;
use crate::inequality::{BodyFactor, Matrices};
use crate::linalg::vector::{add_scaled, norm};
use crate::linalg::{LinearOperator, SparseRowsBuilder, Workspace};
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::evaluate::evaluate_body;
use crate::model::state::State;
use crate::plan::estimate::MOST_RESPONSE_FLOPS;
use crate::sqp::run::Run;

/// What `task` makes of the response, which is made where it is not known yet; none where there
/// is none.
pub(super) fn with<T>(
    run: &mut Run<'_>,
    task: impl FnOnce(&mut Response, &mut Run<'_>) -> Option<T>,
) -> Option<T> {
    let mut known = std::mem::take(&mut run.learned.response);
    if matches!(known, Known::Nothing) {
        known = known_now(run);
    }
    let done = match &mut known {
        Known::Response(response) => task(response, run),
        Known::Nothing | Known::Refused => None,
    };
    run.learned.response = known;
    done
}

/// Whether an increment under that drive is one for it.
pub(super) fn serves(run: &Run<'_>, drive: &Drive) -> bool {
    let step = run.watch.record.step;
    let is_due = (run.model.plan.decisions.response.from).is_some_and(|from| step >= from);
    is_due && !drive.is_pushed() && run.model.conditions.proximal.is_none()
}

/// The response, found with the prepared data or made now.
fn known_now(run: &mut Run<'_>) -> Known {
    let prepared = run.model.prepared;
    let of_sessions = &prepared.of_sessions;
    let unknowns = surface_unknowns(&run.model);
    let fields = run.model.plan.decisions.response.fields;
    let is_wanted = |body: &BodyResponse| body.columns.are_of(&unknowns, fields);
    if let Some(body) = of_sessions.find(is_wanted) {
        return known(body);
    }
    let start = std::time::Instant::now();
    let places = run.learned.layout(&run.model).places.clone();
    let factor = factor_of(run);
    run.counters.seconds.factorise += start.elapsed().as_secs_f64();
    match factor {
        Some(factor) => {
            run.counters.factorisations += 1;
            let made = BodyResponse {
                volumes: volumes(&run.model, &unknowns, run.work),
                accuracy: accuracy(&run.model, (&factor, &unknowns), run.work),
                columns: Columns::new(unknowns, &places, fields),
                factor,
            };
            known(of_sessions.offer(made, |a, b| a.columns.are_like(&b.columns)))
        }
        None if run.stopped().is_some() => Known::Nothing,
        None => Known::Refused,
    }
}

fn known(body: Arc<BodyResponse>) -> Known {
    Known::Response(Box::new(Response {
        body,
        near: Near::default(),
        free: None,
    }))
}

/// K as a factor; none where it does not fit, or the increment is stopped.
fn factor_of(run: &mut Run<'_>) -> Option<BodyFactor> {
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
        has_rigid_modes: false,
        most_flops: MOST_RESPONSE_FLOPS,
    };
    BodyFactor::new(&matrices).ok()
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

/// What a solution with the factor leaves of a load of one on each of `unknowns`: what a smooth
/// load moves is most, and so is what the shift of the factor does.
fn accuracy(
    model: &Model<'_>,
    (factor, unknowns): (&BodyFactor, &[u32]),
    work: &mut Workspace,
) -> Accuracy {
    let mut state = State::undeformed(model.plan);
    let size = state.displacement.len();
    let mut solution = vec![0.0; factor.size()];
    (unknowns.iter()).for_each(|&unknown| solution[unknown as usize] = 1.0);
    let load = solution[..size].to_vec();
    factor.solve(&mut solution, work);
    let (moved, pressure) = solution.split_at(size);
    state.displacement.copy_from_slice(moved);
    state.pressure.copy_from_slice(pressure);
    let mut left = evaluate_body(model, &state, work);
    add_scaled(&mut left.force, 1.0, &load);
    let size = norm(&load).max(f64::MIN_POSITIVE);
    Accuracy {
        force: norm(&left.force) / size,
        volume: norm(&left.constraint) / size,
    }
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
