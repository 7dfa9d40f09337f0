//! What friction does on each obstacle: force and moment of its tractions, which points
//! stick, slip and are open, and the energy that slip has cost.
//!
//! ```text
//! force = sum m_i t_i,   moment = sum int phi_i (x - c) dS x t_i,   dissipated = -sum t_i . s_i
//! ```
//!
//! Tractions are per undeformed area. The stick margin is the least 1 - |t| / r of what
//! sticks. Cost: a sparse product and a pass over the points.

use std::collections::BTreeMap;

use crate::geometry::vector3::{add, cross, norm, scale, sub};
use crate::model::Model;
use crate::model::friction::{Frame, Friction};
use crate::model::state::State;
use crate::obstacle::Obstacle;
use crate::report::{BodyContactResult, BodyFriction, ObstacleResult};
use crate::saddle::Status;

/// Adds what friction does to the results of the obstacles, in the caller's units.
pub(crate) fn add_friction(
    model: &Model<'_>,
    state: &State,
    results: &mut BTreeMap<String, ObstacleResult>,
) {
    let Some(friction) = &model.interfaces.friction else {
        return;
    };
    let tractions = tractions(friction, &friction.frames(model, state), state);
    let units = &model.plan.problem.units;
    let obstacles = model.interfaces.obstacles(&state.drive, units.length);
    let traces = friction.traces(model, state);
    let moments = traces.moments(model.prepared.space.components, &state.displacement);
    let radii = friction
        .law(model.plan, &state.drive)
        .radii(&state.multiplier);
    for (index, (planned, met)) in model
        .plan
        .problem
        .obstacles
        .iter()
        .zip(&obstacles)
        .enumerate()
    {
        let Some(result) = results
            .get_mut(&planned.name)
            .filter(|_| planned.is_frictional)
        else {
            continue;
        };
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        let reference = met.reference_point();
        for (number, point) in friction.points.iter().enumerate() {
            if point.obstacle != index {
                continue;
            }
            let traction = tractions[number];
            let weight = traces.weights[number];
            force = add(force, scale(weight, traction));
            let arm = sub(moments[number], scale(weight, reference));
            moment = add(moment, cross(arm, traction));
            let margin = 1.0 - norm(traction) / radii[number];
            count(result, friction, (number, margin), state);
            let travel = &state.slip.travel[3 * number..3 * number + 3];
            let slip = travel.iter().fold(0.0, |sum: f64, x| sum.hypot(*x)) * units.length;
            result.max_slip = result.max_slip.max(slip);
        }
        result.tangential_force = force.map(|x| x * units.force());
        result.force = add(result.force, result.tangential_force);
        result.moment = add(result.moment, moment.map(|x| x * units.energy()));
        result.dissipated_energy = state.slip.increment[index] * units.energy();
        result.dissipated_total = state.slip.total[index] * units.energy();
    }
}

/// Adds what friction does to the results of the contacts between bodies, in the caller's units.
pub(crate) fn add_friction_between(
    model: &Model<'_>,
    state: &State,
    results: &mut BTreeMap<String, BodyContactResult>,
) {
    let Some(friction) = &model.interfaces.friction else {
        return;
    };
    let units = &model.plan.problem.units;
    let law = friction.law(model.plan, &state.drive);
    let radii = law.radii(&state.multiplier);
    let body = model.deformed(&state.displacement);
    for own in friction.between(model, state) {
        let name = own.name;
        let planned = model.plan.problem.pairs.iter().find(|one| one.name == name);
        let (Some(planned), Some(result)) = (planned, results.get_mut(name)) else {
            continue;
        };
        let tractions = &state.multiplier[friction.tractions_of(&own.points)];
        let sliding = (own.surface, &own.sliding);
        let forces = own.pair.forces_of_tractions(&body, sliding, tractions);
        let (force, moment) = if planned.first_carries() {
            (forces.on_carrier, forces.moment)
        } else {
            (forces.on_other, forces.other_moment)
        };
        let mut done = ObstacleResult::default();
        let tractions = tractions.chunks_exact(friction.components.count());
        for (number, traction) in own.points.clone().zip(tractions) {
            let size = traction.iter().fold(0.0, |size: f64, t| size.hypot(*t));
            let margin = 1.0 - size / radii[number];
            count(&mut done, friction, (number, margin), state);
            let travel = &state.slip.travel[3 * number..3 * number + 3];
            let slip = travel.iter().fold(0.0, |sum: f64, x| sum.hypot(*x)) * units.length;
            done.max_slip = done.max_slip.max(slip);
        }
        let place = friction.points[own.points.start].obstacle;
        let tangential = force.map(|x| x * units.force());
        result.force = add(result.force, tangential);
        result.moment = add(result.moment, moment.map(|x| x * units.energy()));
        result.friction = Some(BodyFriction {
            tangential_force: tangential,
            stick_vertices: done.stick_vertices,
            slip_vertices: done.slip_vertices,
            open_vertices: done.open_vertices,
            max_slip: done.max_slip,
            stick_margin: done.stick_margin,
            dissipated_energy: state.slip.increment[place] * units.energy(),
            dissipated_total: state.slip.total[place] * units.energy(),
        });
    }
}

/// Counts a point by what it does, with the margin of what sticks.
fn count(
    result: &mut ObstacleResult,
    friction: &Friction,
    (number, margin): (usize, f64),
    state: &State,
) {
    let partner = friction.partners[number] as usize;
    let first = friction.first + number * friction.components.count();
    match (state.status[partner].is_closed(), state.status[first]) {
        (false, _) => result.open_vertices += 1,
        (true, Status::Stick) => {
            result.stick_vertices += 1;
            let least = result.stick_margin.unwrap_or(f64::INFINITY);
            result.stick_margin = Some(least.min(margin));
        }
        (true, Status::Open | Status::Slip) => result.slip_vertices += 1,
    }
}

/// Traction vectors of all points, in units of the scaled body `[points][3]`.
pub(crate) fn tractions(friction: &Friction, frames: &[Frame], state: &State) -> Vec<[f64; 3]> {
    let width = friction.components.count();
    let own = state.multiplier[friction.first..].chunks_exact(width);
    let vector = |(frame, own): (&Frame, &[f64])| {
        let parts = frame.iter().zip(own);
        parts.fold([0.0; 3], |sum, (tangent, value)| {
            add(sum, scale(*value, *tangent))
        })
    };
    frames.iter().zip(own).map(vector).collect()
}

/// Tractions of friction at uploaded vertices `[vertices, 3]`, in the caller's units; none
/// without friction.
pub(crate) fn friction_traction(model: &Model<'_>, state: &State) -> Option<Vec<f64>> {
    let friction = model.interfaces.friction.as_ref()?;
    let tractions = tractions(friction, &friction.frames(model, state), state);
    let unit = model.plan.problem.units.stress;
    Some(at_vertices(model, |point| {
        tractions[point].map(|x| x * unit)
    }))
}

/// Slip of the last increment at uploaded vertices `[vertices, 3]`, a length; none without
/// friction.
pub(crate) fn slip(model: &Model<'_>, state: &State) -> Option<Vec<f64>> {
    model.interfaces.friction.as_ref()?;
    let (unit, (points, _)) = (
        model.plan.problem.units.length,
        state.slip.travel.as_chunks::<3>(),
    );
    Some(at_vertices(model, |point| points[point].map(|x| x * unit)))
}

/// The functions' sums of what their points have, at uploaded vertices `[vertices, 3]`.
fn at_vertices(model: &Model<'_>, of_point: impl Fn(usize) -> [f64; 3]) -> Vec<f64> {
    let mut out = vec![0.0; 3 * model.mesh.vertex_count()];
    let mut first = 0;
    let own = model.frictional().map(|(_, interface)| interface);
    for interface in own.chain(model.frictional_pairs()) {
        let surface = &interface.surface;
        for (function, &node) in (0..).zip(&surface.carriers) {
            let Some(&uploaded) = model.mesh.used_vertices().get(node as usize) else {
                continue; // An edge: fields are values at vertices.
            };
            for (multiplier, share) in surface.shares.of(function) {
                let value = of_point(first + multiplier as usize);
                let own = &mut out[3 * uploaded as usize..3 * uploaded as usize + 3];
                own.iter_mut()
                    .zip(value)
                    .for_each(|(sum, x)| *sum += share * x);
            }
        }
        first += interface.multipliers.len();
    }
    out
}
