//! How long parts may be so that no round tool passes through the body: it would come out on
//! the other side, or close over a part of the surface, and push the wrong way.
//!
//! A tool that advances by less than half its radius from where it is not inside the body
//! cannot. Parts are bounded only where it would be deep inside on its way. Cost: none where
//! tools advance by less; else some distances a face.

use crate::contact::nearest::nearest;
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::state::State;
use crate::obstacle::Obstacle;

/// Advance and depth, over the tool's radius, that are harmless.
const HARMLESS: f64 = 0.5;
/// Poses that are looked at, a radius of the way.
const POSES: f64 = 4.0;
/// Poses at most.
const MOST_POSES: f64 = 200.0;

/// The longest part of the way from the drive of `state` to `goal`, in (0, 1].
pub(super) fn longest_part(model: &Model<'_>, state: &State, goal: &Drive) -> f64 {
    let length = model.plan.units.length;
    let [from, to] = [&state.drive, goal].map(|drive| model.interfaces.obstacles(drive, length));
    let mut longest = 1.0_f64;
    for (index, (from, to)) in from.iter().zip(&to).enumerate() {
        let (Some(ball), Some(end)) = (from.inner_ball(), to.inner_ball()) else {
            continue;
        };
        let (radius, ends) = (ball.radius, [ball.centre, end.centre]);
        let squares = (0..3).map(|i| (ends[1][i] - ends[0][i]).powi(2));
        let advance = squares.sum::<f64>().sqrt();
        let is_far = advance > HARMLESS * radius;
        if is_far && is_deep(model, state, (goal, index), (advance, radius)) {
            longest = longest.min(HARMLESS * radius / advance);
        }
    }
    longest
}

/// Whether an obstacle is deep inside the body, as it is, somewhere on its way.
fn is_deep(
    model: &Model<'_>,
    state: &State,
    (goal, index): (&Drive, usize),
    (advance, radius): (f64, f64),
) -> bool {
    let poses = (POSES * advance / radius).min(MOST_POSES).ceil();
    let body = model.deformed(&state.displacement);
    (1..=poses as u32).any(|pose| {
        let drive = state.drive.towards(goal, f64::from(pose) / poses);
        let met = model.placed(&drive).nth(index);
        met.is_some_and(|(interface, met)| {
            let distances = nearest(&body, &interface.surface, &met);
            distances
                .into_iter()
                .any(|distance| distance < -HARMLESS * radius)
        })
    })
}
