//! Where an obstacle has been on its way through an increment, beside the body as it moved:
//!
//! ```text
//! d(s) = min over faces of the distance,   pose and displacement a share s of the way
//! ```
//!
//! Both ways are taken straight, in all components of the pose: a body that turns far within an
//! increment is looked at where it ends. Distances are lengths of the scaled body. Cost: some
//! distances a face at poses as far apart as the obstacle is from the body.

use super::touch::Touch;
use crate::linalg::vector::norm;
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::interfaces::{Interface, Role};
use crate::model::state::{Start, State};
use crate::model::travel::{least_distance, travel};
use crate::proximity::path::March;
use crate::report::{Warning, WarningKind};

/// Depth over the length of the body from which on an obstacle is inside it.
const DEEP: f64 = 0.01;
/// Least way between two poses that are looked at, over the length of the body.
const POSE_SPACING: f64 = 0.25 * DEEP;
/// The same for an obstacle that presses, and the least way that is looked at.
const WIDE_SPACING: f64 = 2.0 * DEEP;
const LEAST_WAY: f64 = 10.0 * DEEP;
/// Turn of a support, radians, along which its body is not taken to move straight.
const FAR_TURN: f64 = 0.3;

/// An obstacle that touches nothing though it came no farther away.
pub(super) fn untouched(
    model: &Model<'_>,
    (start, touch): (&Start, &Touch<'_>),
) -> Option<Warning> {
    let at_start = (&start.drive, &start.displacement[..]);
    let before = least_distance(model, at_start, touch.interface);
    let now = least(&touch.distances);
    (now > 0.0 && now <= before * (1.0 + 1e-12)).then(|| {
        let name = &touch.interface.name;
        let gap = now * model.plan.problem.units.length;
        Warning::new(
            WarningKind::UntouchedObstacle,
            name,
            Some(gap),
            format!("obstacle `{name}` touches nothing: it is {gap:.4} away from the body"),
        )
    })
}

/// An obstacle that touches nothing at the end but was inside the body on its way.
pub(super) fn passed(
    model: &Model<'_>,
    ends: (&Start, &State),
    interface: &Interface,
) -> Option<Warning> {
    let deepest = deepest(model, ends, interface, POSE_SPACING);
    (deepest > DEEP).then(|| through(model, interface, deepest))
}

/// An obstacle that presses at the end but was deeper inside the body on its way than it is at
/// either end in the body as the other end has it, which is how deep one is that slides. Not
/// looked for on ways shorter than the obstacle is thick, nor where supports turn the body far.
pub(super) fn passed_and_presses(
    model: &Model<'_>,
    (start, state): (&Start, &State),
    interface: &Interface,
) -> Option<Warning> {
    let Role::Contact(shape) = &interface.role else {
        return None;
    };
    // One that moves by less than its thickness comes out nowhere.
    let thickness = 2.0 * shape.inner_ball()?.radius;
    let way = way(model, (start, state), interface);
    if way < LEAST_WAY.max(thickness) || turns_far(start, state) {
        return None;
    }
    let crosswise = [
        (&start.drive, &state.displacement[..]),
        (&state.drive, &start.displacement),
    ];
    let usual = crosswise.map(|at| -least_distance(model, at, interface));
    let usual = usual[0].max(usual[1]).max(0.0);
    let deepest = deepest(model, (start, state), interface, WIDE_SPACING);
    (deepest > usual + DEEP).then(|| through(model, interface, deepest))
}

fn through(model: &Model<'_>, interface: &Interface, deepest: f64) -> Warning {
    let name = &interface.name;
    Warning::new(
        WarningKind::PassedThrough,
        name,
        Some(deepest * model.plan.problem.units.length),
        format!(
            "obstacle `{name}` passed through the body within the increment: take more increments"
        ),
    )
}

/// How far an obstacle and the body move at most beside each other.
fn way(model: &Model<'_>, (start, state): (&Start, &State), interface: &Interface) -> f64 {
    let bodies = [&start.displacement[..], &state.displacement];
    let own = travel(model, interface, [&start.drive, &state.drive], &bodies);
    own + longest(model, &moved(start, state))
}

/// Greatest depth that an obstacle comes to on its way, at poses `spacing` apart at least.
fn deepest(
    model: &Model<'_>,
    (start, state): (&Start, &State),
    interface: &Interface,
    spacing: f64,
) -> f64 {
    let way = way(model, (start, state), interface);
    let moved = moved(start, state);
    let mut displacement = state.displacement.clone();
    let mut distance_at = |share: f64| {
        let drive = start.drive.towards(&state.drive, share);
        let entries = state.displacement.iter().zip(&moved);
        for (at, (end, moved)) in displacement.iter_mut().zip(entries) {
            *at = end - (1.0 - share) * moved;
        }
        least_distance(model, (&drive, &displacement), interface)
    };
    let mut march = March::new(way, spacing, interface.surface.faces.len());
    // What touches the body at the start may overlap it between the nodes.
    let mut last = if way > 0.0 { distance_at(0.0) } else { 0.0 };
    let mut deepest = 0.0_f64;
    while let Some(share) = march.next(last).filter(|&share| share < 1.0) {
        let distance = distance_at(share);
        if distance < last {
            deepest = deepest.max(-distance);
        }
        last = distance;
    }
    deepest
}

/// An obstacle that is deep inside the undeformed body before the first increment.
pub(super) fn begun_inside(
    model: &Model<'_>,
    start: &Start,
    interface: &Interface,
) -> Option<Warning> {
    if start.drive != Drive::undeformed(model.plan) {
        return None;
    }
    let at_rest = vec![0.0; model.prepared.space.displacement_unknowns()];
    let depth = -least_distance(model, (&start.drive, &at_rest), interface);
    (depth > DEEP).then(|| {
        let (name, depth) = (&interface.name, depth * model.plan.problem.units.length);
        Warning::new(
            WarningKind::BeginsInside,
            name,
            Some(depth),
            format!("obstacle `{name}` begins {depth:.4} deep inside the body"),
        )
    })
}

/// How the body moved from `start` to `state` `[displacement]`; not at all where supports turn
/// it far.
fn moved(start: &Start, state: &State) -> Vec<f64> {
    if turns_far(start, state) {
        return vec![0.0; state.displacement.len()];
    }
    let entries = state.displacement.iter().zip(&start.displacement);
    entries.map(|(end, start)| end - start).collect()
}

/// Whether supports turn the body farther than its way can be taken straight.
fn turns_far(start: &Start, state: &State) -> bool {
    let turns = start.drive.motions.iter().zip(&state.drive.motions);
    let mut turns = turns.map(|(from, to)| distance(from.rotation, to.rotation));
    turns.any(|turn| turn > FAR_TURN)
}

/// Largest motion of a node.
fn longest(model: &Model<'_>, moved: &[f64]) -> f64 {
    let nodes = moved.chunks_exact(model.prepared.space.components);
    nodes.map(norm).fold(0.0, f64::max)
}

/// Length of a - b `[3]`.
fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    norm(&[a[0] - b[0], a[1] - b[1], a[2] - b[2]])
}

fn least(distances: &[f64]) -> f64 {
    distances.iter().copied().fold(f64::INFINITY, f64::min)
}
