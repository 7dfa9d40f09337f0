//! What each obstacle exerts on the body, as pushes ask for it: the force and the moment of
//! its report.

use std::collections::BTreeMap;

use super::friction::add_friction;
use super::touching::Touching;
use crate::model::Model;
use crate::model::state::State;
use crate::plan::Plan;
use crate::report::ObstacleResult;

/// Forces, then moments about the reference points `[obstacles][6]`, in the caller's units.
pub(crate) fn exerted(model: &Model<'_>, state: &State) -> Vec<[f64; 6]> {
    let mut results = Touching::of(model, state).results(|_, _, _| {});
    add_friction(model, state, &mut results);
    of_all(model.plan, &results)
}

/// The same from results by name, in the order of the plan.
pub(crate) fn of_all(plan: &Plan, results: &BTreeMap<String, ObstacleResult>) -> Vec<[f64; 6]> {
    let of_one = |name: &String| {
        let mut exerted = [0.0; 6];
        if let Some(result) = results.get(name) {
            exerted[..3].copy_from_slice(&result.force);
            exerted[3..].copy_from_slice(&result.moment);
        }
        exerted
    };
    plan.obstacles.iter().map(|one| of_one(&one.name)).collect()
}
