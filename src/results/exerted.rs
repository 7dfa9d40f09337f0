//! What each obstacle exerts on the body, as pushes ask for it: the force and the moment of
//! its report.

use super::friction::add_friction;
use super::touching::Touching;
use crate::model::Model;
use crate::model::state::State;

/// Forces, then moments about the reference points `[obstacles][6]`, in the caller's units.
pub(crate) fn exerted(model: &Model<'_>, state: &State) -> Vec<[f64; 6]> {
    let mut results = Touching::of(model, state).results(|_, _, _| {});
    add_friction(model, state, &mut results);
    let of_one = |name: &String| {
        let mut exerted = [0.0; 6];
        if let Some(result) = results.get(name) {
            exerted[..3].copy_from_slice(&result.force);
            exerted[3..].copy_from_slice(&result.moment);
        }
        exerted
    };
    let obstacles = model.plan.problem.obstacles.iter();
    obstacles.map(|one| of_one(&one.name)).collect()
}
