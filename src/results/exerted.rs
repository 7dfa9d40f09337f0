//! What obstacles and supports exert on the body, as pushes ask for it: the force and the moment
//! of their reports, of supports with what their springs take,
//!
//! ```text
//! F = f + k z
//! ```
//!
//! f what the support exerts, k its spring to the ground, z its pose.

use super::friction::add_friction;
use super::reactions::reactions;
use super::touching::Touching;
use crate::linalg::Workspace;
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::internal::internal;
use crate::model::push::{Applied, Part, joined};
use crate::model::state::State;
use crate::report::SupportResult;
use crate::scene::validate::ResolvedSupport;

/// By obstacles and, where any is pushed under `drive`, by supports.
pub(crate) fn applied(model: &Model<'_>, state: &State, drive: &Drive) -> Applied {
    let supports = if drive.support_pushes.is_empty() {
        Vec::new()
    } else {
        by_supports(model, state)
    };
    Applied {
        obstacles: by_obstacles(model, state),
        supports,
    }
}

/// `[obstacles][6]`.
fn by_obstacles(model: &Model<'_>, state: &State) -> Vec<[f64; 6]> {
    let mut results = Touching::of(model, state).results(|_, _, _| {});
    add_friction(model, state, &mut results);
    let of_one = |name: &String| {
        let result = results.get(name);
        result.map_or([0.0; 6], |result| joined(result.force, result.moment))
    };
    let obstacles = model.plan.problem.obstacles.iter();
    obstacles.map(|one| of_one(&one.name)).collect()
}

/// `[supports][6]`.
fn by_supports(model: &Model<'_>, state: &State) -> Vec<[f64; 6]> {
    let inside = internal(model, state, &mut Workspace::new());
    let found = reactions(model, state, inside.force);
    let supports = model.plan.problem.resolved.supports.iter().enumerate();
    let of_one = |(index, support): (usize, &ResolvedSupport)| {
        let SupportResult { force, moment, .. } =
            found.get(&support.name).copied().unwrap_or_default();
        let mut applied = joined(force, moment);
        let pose = state.drive.pose(Part::Support(index));
        let sprung = support.spring.iter().zip(pose);
        applied
            .iter_mut()
            .zip(sprung)
            .for_each(|(sum, (spring, z))| *sum += spring * z);
        applied
    };
    supports.map(of_one).collect()
}
