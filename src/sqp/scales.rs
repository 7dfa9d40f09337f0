//! What residuals of an increment are measured by, beside the norms that it sees: nothing that
//! has passed, and no less than rounding (decision 36).
//!
//! Scales of forces, gaps `|C u|` and volumes `|B u|`, non-dimensional norms over all unknowns.
//! Cost: some products with C and one with the stiffness at rest.

use super::run::Run;
use crate::inequality::QpScales;
use crate::linalg::vector::{dot, largest, norm, reproducible_noise};
use crate::linalg::{LinearOperator, Workspace};
use crate::model::Model;
use crate::model::evaluate::Evaluation;
use crate::model::state::State;

constants! {
    /// Stress in shear moduli below which a body without load is at rest: linear, and of rubber,
    /// whose law has a scale of its own.
    const LEAST_STRESS: [f64; 2] = [1e-11, 1e-9];
    /// Roundings that one entry of a force adds up.
    const ROUNDINGS: f64 = 8.0;
    /// Most of a body's length by which surfaces that move together count as moved: bodies that are
    /// carried far lose no digits of their contact.
    const TOGETHER: f64 = 0.01;
}

/// Lets the scales of a body that nothing drives any more be those of a fresh one: what
/// they have seen says nothing of what comes.
pub(super) fn forget_scales(run: &mut Run<'_>) {
    let state = &mut *run.state;
    let is_loaded = state.drive.is_loaded(run.model.plan);
    if !touches(state) && !is_loaded && !state.drive.moves_supports() {
        state.scales = QpScales::default();
    }
}

/// Whether any multiplier of contact is at work.
pub(super) fn touches(state: &State) -> bool {
    state.multiplier.iter().any(|&value| value != 0.0)
}

/// Keeps the scale of the gap to what contact has moved the surface by: a lift, or a body
/// carried far, has seen larger ones.
pub(super) fn limit_gap_scale(model: &Model<'_>, state: &mut State, now: &Evaluation) {
    let mut moved = vec![0.0; state.multiplier.len()];
    let mut work = Workspace::new();
    now.coupling
        .apply(&state.displacement, &mut moved, &mut work);
    for (place, own) in between_bodies(model, state, now) {
        moved[place] = own;
    }
    let closed = moved.iter().zip(&state.status);
    let closed = closed.filter(|(_, status)| status.is_closed());
    let square: f64 = closed.map(|(moved, _)| moved * moved).sum();
    state.scales.gap = state.scales.gap.min(square.sqrt());
}

/// How far both surfaces of each multiplier between bodies have moved, weighted, where it is closed:
/// bodies that move together close no gap, and see none.
fn between_bodies(model: &Model<'_>, state: &State, now: &Evaluation) -> Vec<(usize, f64)> {
    let mut all = Vec::new();
    let list = model.interfaces.list.iter();
    for interface in list.filter(|interface| !interface.is_by_points()) {
        for (place, &weight) in interface.places().zip(&interface.surface.weights) {
            let (columns, values) = now.coupling.row(place);
            let entries = columns.iter().zip(values);
            let moved = entries.map(|(&k, value)| (value * state.displacement[k as usize]).abs());
            if state.status[place].is_closed() {
                all.push((place, moved.sum::<f64>().min(TOGETHER * weight)));
            }
        }
    }
    all
}

/// Keeps the scales of gaps and volumes to what their rounding is within the
/// tolerance of, of rubber that of a body of length one. Those of volumes of a linear body
/// that nothing acts on are those of one at rest: what a tool leaves behind that has let go is
/// nothing, and a program for it would only make it less.
pub(super) fn raise_scales(model: &Model<'_>, state: &mut State, now: &Evaluation) {
    let least = ROUNDINGS * f64::EPSILON / model.conditions.tolerance;
    let (c, mut work) = (model.prepared.space.components, Workspace::new());
    let mut square = 0.0;
    for axis in 0..model.plan.problem.units.dimension {
        let mut carried = vec![0.0; state.displacement.len()];
        let own = carried[..c * model.prepared.space.vertices].iter_mut();
        own.skip(axis).step_by(c).for_each(|entry| *entry = 1.0);
        let mut moved = vec![0.0; state.multiplier.len()];
        now.coupling.apply(&carried, &mut moved, &mut work);
        square += dot(&moved, &moved);
    }
    square += carried_past(model, now);
    state.scales.gap = state.scales.gap.max(least * square.sqrt());
    let together = between_bodies(model, state, now).into_iter();
    let together: f64 = together.map(|(_, moved)| moved * moved).sum();
    state.scales.gap = state.scales.gap.max(together.sqrt());
    let volumes = if model.is_rubber() {
        least / (model.prepared.space.vertices as f64).sqrt()
    } else {
        let rounding = volume_rounding(model, state) / model.conditions.tolerance;
        let alone = is_left_alone(state, now).then(|| at_rest(model, now));
        alone.map_or(rounding, |at_rest| at_rest.max(rounding))
    };
    state.scales.constraint = state.scales.constraint.max(volumes);
}

/// Square of what carrying one of two bodies by its length past the other makes of the gaps between
/// them, which carrying both makes nothing of.
fn carried_past(model: &Model<'_>, now: &Evaluation) -> f64 {
    let vertices = model.prepared.space.components * model.prepared.space.vertices;
    let pairs = model.interfaces.list.iter();
    let pairs = pairs.filter(|interface| interface.pair().is_some());
    let of_both = |place: usize| -> f64 {
        let (columns, values) = now.coupling.row(place);
        let entries = columns.iter().zip(values);
        let own = entries.filter(|&(&k, _)| (k as usize) < vertices);
        own.map(|(_, value)| value.abs()).sum()
    };
    let squares = pairs.flat_map(|interface| interface.places());
    squares.map(|place| (0.5 * of_both(place)).powi(2)).sum()
}

/// Whether nothing acts on the body: no load, no support that has moved and no obstacle.
fn is_left_alone(state: &State, now: &Evaluation) -> bool {
    let is_driven = now.load_norm > 0.0 || state.drive.moves_supports();
    !is_driven && !touches(state) && now.gap_norm(state) == 0.0
}

/// Norm of the forces, and of the changes of volume, of a body without load that is at rest:
/// those of a stress of some [`LEAST_STRESS`] shear moduli.
fn at_rest(model: &Model<'_>, now: &Evaluation) -> f64 {
    let vertices = (model.prepared.space.vertices as f64).sqrt();
    if now.load_norm > 0.0 {
        0.0
    } else {
        LEAST_STRESS[usize::from(model.is_rubber())] / vertices
    }
}

/// Norm of a force that stands for one where none at hand is larger: in a body without load a
/// stress of some [`LEAST_STRESS`] shear moduli, and in any body one beside which the rounding
/// of its displacements meets the tolerance.
pub(super) fn least_force(model: &Model<'_>, state: &State, now: &Evaluation) -> f64 {
    at_rest(model, now).max(rounding(model, state) / model.conditions.tolerance)
}

/// Whether the residuals of force and volume at `now` are no more than [`ROUNDINGS`] times what
/// they change by if every unknown is moved by one rounding. Such a state solves a problem whose
/// data differ by roundings (W. Oettli and W. Prager, Numer. Math. 6, 1964).
pub(super) fn is_rounding(run: &mut Run<'_>, now: &Evaluation) -> bool {
    let [displacement, pressure] = [&run.state.displacement, &run.state.pressure].map(Vec::clone);
    round_anew(&mut run.state.displacement);
    round_anew(&mut run.state.pressure);
    let other = run.evaluate();
    (run.state.displacement, run.state.pressure) = (displacement, pressure);
    let is_noise = |here: &[f64], there: &[f64]| {
        let apart: f64 = here.iter().zip(there).map(|(a, b)| (a - b).powi(2)).sum();
        norm(here) <= ROUNDINGS * apart.sqrt()
    };
    is_noise(&now.force, &other.force) && is_noise(&now.constraint, &other.constraint)
}

/// Moves each number by one rounding, up or down by noise that is always the same.
fn round_anew(numbers: &mut [f64]) {
    let noise = reproducible_noise(numbers.len());
    for (number, noise) in numbers.iter_mut().zip(noise) {
        *number *= 1.0 + f64::EPSILON.copysign(noise);
    }
}

/// What rounding of displacements, and of rubber of lengths, leaves of the forces of a body:
/// h^(d - 2) a vertex where cells have the size h in d dimensions.
fn rounding(model: &Model<'_>, state: &State) -> f64 {
    let dimension = model.plan.problem.units.dimension as i32;
    let vertices = model.prepared.space.vertices as f64;
    let size = vertices.powf(-1.0 / f64::from(dimension));
    let length = if model.is_rubber() {
        largest(&state.displacement).max(1.0)
    } else {
        largest(&state.displacement)
    };
    ROUNDINGS * f64::EPSILON * length * size.powi(dimension - 2) * vertices.sqrt()
}

/// What rounding of displacements leaves of the volumes of a linear body that goes as far as what is
/// held of it, h^(d - 1) a vertex: a body that a method leads astray goes farther.
fn volume_rounding(model: &Model<'_>, state: &State) -> f64 {
    let dimension = model.plan.problem.units.dimension as i32;
    let vertices = model.prepared.space.vertices as f64;
    let area = vertices
        .powf(-1.0 / f64::from(dimension))
        .powi(dimension - 1);
    let held = model.prepared.held.entries.iter();
    let ways = held.map(|&entry| state.displacement[entry as usize].abs());
    ROUNDINGS * f64::EPSILON * ways.fold(0.0, f64::max) * area * vertices.sqrt()
}
