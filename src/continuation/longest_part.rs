//! How long parts may be so that no round tool passes through the body: it would come out on
//! the other side, or close over a part of the surface, and push the wrong way.
//!
//! A tool that advances by less than half its radius from where it is not inside the body
//! cannot. Parts are bounded only where it would be deep inside on its way, and only from where
//! it touches the body, as this is: before that the tool moves at once. Advances are bounds over
//! the faces ([`crate::model::travel`]), so that tools which turn are seen, and a tool that
//! crosses a face is deep in it on the way however far it goes on. Cost: none where tools advance
//! by less; else some distances a face, at poses as far apart as the tool is from the body.

use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::interfaces::{Interface, Role};
use crate::model::state::State;
use crate::model::travel::{least_distance, travel};
use crate::proximity::path::March;

constants! {
    /// Advance and depth, over the tool's radius, that are harmless.
    const HARMLESS: f64 = 0.5;
    /// Least advance between poses that are looked at, over the tool's radius.
    const POSE_SPACING: f64 = 0.25;
    /// Bounded parts after the first touch at most; a tool that would need more may pass.
    pub(super) const MOST_PARTS: f64 = 1000.0;
}

/// The longest part of the path from the drive of `state` to `goal` that may be taken from there,
/// in (0, 1].
pub(super) fn longest_part(model: &Model<'_>, state: &State, goal: &Drive) -> f64 {
    let longest = model.interfaces.list.iter().map(|interface| {
        let Role::Contact(shape) = &interface.role else {
            return 1.0;
        };
        let radius = shape.inner_ball().map(|ball| ball.radius);
        radius.map_or(1.0, |radius| {
            longest_of(model, (state, goal), (interface, radius))
        })
    });
    longest.fold(1.0, f64::min)
}

/// That of one tool: to where it touches the body, or a harmless advance.
fn longest_of(
    model: &Model<'_>,
    (state, goal): (&State, &Drive),
    (interface, radius): (&Interface, f64),
) -> f64 {
    let ends = [&state.drive, goal];
    let way = travel(model, interface, ends, &[&state.displacement]);
    let harmless = HARMLESS * radius;
    if way <= harmless {
        return 1.0;
    }
    let distance_at = |share: f64| {
        let drive = state.drive.towards(goal, share);
        least_distance(model, (&drive, &state.displacement), interface)
    };
    let spacing = POSE_SPACING * radius;
    let mut march = March::new(way, spacing, interface.surface.faces.len());
    let (mut share, mut distance) = (0.0, distance_at(0.0));
    let (mut free, mut is_free) = (0.0, true);
    loop {
        is_free &= distance > 0.0;
        if is_free {
            free = share + distance / way;
        }
        let Some(next) = march.next(distance) else {
            return 1.0;
        };
        (share, distance) = (next, distance_at(next));
        if distance < -harmless {
            return (harmless / way).max(free).min(1.0);
        }
    }
}
