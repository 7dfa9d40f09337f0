//! Causes that the methods can only notice as stagnation: loads that nothing resists,
//! a volume that cannot change, a body about to snap.

mod enclosure;
pub(crate) mod site;
pub(crate) mod uniqueness;

use crate::contact::gap::{Deformed, Measure};
use crate::linalg::Workspace;
use crate::linalg::vector::{add_scaled, dot, norm};
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::ending::{Ending, Site};
use crate::model::evaluate::external_force;
use crate::model::inside_out::inside_out;
use crate::model::state::State;
use crate::obstacle::{Contact, Derivatives, Obstacle};
use crate::report::{Cause, Termination};
use crate::sqp::run::Run;
use enclosure::{constant_pressure_force, is_full};

constants! {
    /// Least eigenvalue over that at rest below which a body is about to snap.
    const SOFT: f64 = 0.1;
    /// Share of a constant pressure's forces that contact may leave.
    const CLOSED: f64 = 1e-6;
    /// Sum of forces over the sum of their sizes below which they balance.
    const BALANCED: f64 = 1e-9;
    /// Gap over the length of the body up to which an obstacle may come to touch.
    const NEAR: f64 = 0.1;
}

/// Names what the Krylov method could only notice as stagnation.
pub(crate) fn explain(run: &mut Run<'_>, ending: &mut Ending) {
    let stuck = ending.cause.is_some_and(Cause::is_numerical);
    // A factor moves the body where iterations would stagnate.
    let is_forced = run.learned.factored.is_some() && ending.cause == Some(Cause::NegativeJacobian);
    // What slides off without end leaves all numbers.
    let is_lost = ending.cause == Some(Cause::NotFinite);
    let model = &run.model;
    if is_lost && slides_off(model, run.state) == Some(true) {
        ending.cause = Some(Cause::NoEquilibrium);
    }
    if !stuck && !is_forced {
        return;
    }
    let touches = run.state.status.iter().any(|status| status.is_closed());
    let has_rigid_modes = model.plan.is_floating() && !touches;
    if slides_off(model, run.state).unwrap_or(has_rigid_modes) {
        ending.cause = Some(Cause::NoEquilibrium);
    } else if is_enclosed(model) || is_closed_by_contact(model, run.state, run.work) {
        ending.cause = Some(Cause::EnclosedVolume);
    }
}

/// Takes it back that a state converged in which a cell is inside out: what balances there is
/// the mesh, not the body. Smaller parts may lead past it.
pub(crate) fn refuse_inside_out(run: &Run<'_>, ending: &mut Ending) {
    if ending.termination != Termination::Converged {
        return;
    }
    if let Some(point) = inside_out(&run.model, run.state) {
        ending.termination = Termination::NotConverged;
        ending.cause = Some(Cause::InsideOut);
        ending.site = Some(Site {
            point: Some(point),
            ..Site::default()
        });
    }
}

/// Whether the load on a body that one frictional plane alone holds is outside of the cone of
/// friction; none for other bodies, and where the load is balanced in itself.
fn slides_off(model: &Model<'_>, state: &State) -> Option<bool> {
    let [planned] = &model.plan.problem.obstacles[..] else {
        return None;
    };
    let is_held = !model.plan.problem.resolved.supports.is_empty();
    if is_held || planned.tresca.is_some() || !planned.is_frictional || !planned.shape.is_flat() {
        return None;
    }
    let space = &model.prepared.space;
    let load = external_force(model, state);
    let (mut force, mut size) = ([0.0; 3], 0.0);
    for vertex in load.chunks_exact(space.components).take(space.vertices) {
        force.iter_mut().zip(vertex).for_each(|(sum, x)| *sum += x);
        size += norm(vertex);
    }
    // What is left of forces that cancel is rounding, and has no direction.
    if norm(&force) <= BALANCED * size {
        return None;
    }
    let mut plane = [Contact::default()];
    for met in model
        .interfaces
        .obstacles(&state.drive, model.plan.problem.units.length)
    {
        met.probe(&[[0.0; 3]], Derivatives::Normal, &mut plane);
    }
    let normal = -dot(&force, &plane[0].normal);
    let along = (dot(&force, &force) - normal * normal).max(0.0).sqrt();
    Some(along > state.drive.friction[0] * normal)
}

/// Whether supports alone keep the volume of a body which the material keeps too.
fn is_enclosed(model: &Model<'_>) -> bool {
    let pressure = model.prepared.pressure.as_ref();
    pressure.is_some_and(|block| block.is_enclosed)
}

/// Whether contact, where it is closed or nearly so, would hold a constant pressure at rest:
/// obstacles may then fix a volume which the material fixes too. That is a guess, for what was not
/// solved only.
fn is_closed_by_contact(model: &Model<'_>, state: &State, work: &mut Workspace) -> bool {
    let Some(mut pushed) = constant_pressure_force(model, work) else {
        return false;
    };
    let size = pushed.len();
    let before = norm(&pushed);
    let mut taken: Vec<Vec<f64>> = Vec::new();
    let rest = vec![0.0; size];
    // What contact pushes, without what it would gain by a larger area.
    let body = Deformed {
        measure: Measure::Undeformed,
        ..model.deformed(&rest)
    };
    let present = model.deformed(&state.displacement);
    for (interface, obstacle) in model.placed(&state.drive) {
        let is_held = &model.prepared.is_held;
        let part = obstacle.linearise(&body, &interface.surface, is_held);
        let status = interface.own(&state.status);
        let (gaps, _) = obstacle.gaps(&present, &interface.surface);
        let weighted = gaps.iter().zip(&interface.surface.weights);
        let acts = weighted.zip(status.iter());
        let acts = acts.map(|((gap, weight), status)| status.is_closed() || *gap < NEAR * weight);
        let mut held = vec![0.0; size];
        let rows = part.rows.into_iter().zip(acts);
        for (index, value) in rows.filter(|(_, acts)| *acts).flat_map(|(row, _)| row) {
            held[index as usize] += value;
        }
        model.prepared.held.mask(&mut held);
        // What earlier obstacles on the same faces hold is held.
        for other in &taken {
            let share = dot(&held, other) / dot(other, other);
            add_scaled(&mut held, -share, other);
        }
        let square = dot(&held, &held);
        if square > 0.0 {
            let share = dot(&pushed, &held) / square;
            add_scaled(&mut pushed, -share, &held);
            taken.push(held);
        }
    }
    before > 0.0 && norm(&pushed) <= CLOSED * before
}

/// Names an increment that asks a body for another volume than it has.
pub(crate) fn name_the_impossible(run: &Run<'_>, ending: &mut Ending, goal: &Drive) {
    let may_be_full = is_numerical(ending)
        || matches!(
            ending.cause,
            Some(
                Cause::LimitPoint
                    | Cause::NegativeJacobian
                    | Cause::UnstableEquilibrium
                    | Cause::InsideOut
            )
        );
    let failed = ending.termination == Termination::NotConverged;
    if failed && may_be_full && is_full(&run.model, run.state, goal) {
        ending.cause = Some(Cause::EnclosedVolume);
    }
}

/// Whether the body has grown so soft that it is about to snap.
pub(crate) fn is_soft(run: &Run<'_>) -> bool {
    let mode = run.learned.lowest_mode.as_ref();
    mode.is_some_and(|mode| mode.eigenvalue < SOFT)
}

/// Names the cause of an increment whose parts became too small: a body that has grown
/// soft meets a limit of its load.
pub(crate) fn name_the_end(run: &Run<'_>, ending: &mut Ending) {
    ending.cause = match ending.cause {
        Some(
            Cause::Stagnation
            | Cause::IterationLimit
            | Cause::LineSearch
            | Cause::IndefiniteTangent
            | Cause::NegativeJacobian,
        )
        | None
            if is_soft(run) =>
        {
            Some(Cause::LimitPoint)
        }
        None => Some(Cause::StepTooSmall),
        named => named,
    };
}

/// Whether the cause is that of a method, which says nothing of the body.
fn is_numerical(ending: &Ending) -> bool {
    matches!(
        ending.cause,
        Some(
            Cause::ActiveSetCycle
                | Cause::Stagnation
                | Cause::IterationLimit
                | Cause::LineSearch
                | Cause::IndefiniteTangent
        )
    )
}

/// The numeric constants of this room.
pub(crate) fn constants() -> Vec<crate::constants::Constant> {
    [
        enclosure::own_constants(),
        own_constants(),
        site::own_constants(),
        uniqueness::own_constants(),
    ]
    .concat()
}

#[cfg(test)]
mod tests;
