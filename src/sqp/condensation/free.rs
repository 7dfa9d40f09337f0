//! The body under the loads and supports of a drive, without contact.

use super::kept::{Accuracy, Free, Response};
use crate::inequality::BodyFactor;
use crate::linalg::Workspace;
use crate::linalg::vector::{add_scaled, norm};
use crate::model::Model;
use crate::model::carry::carry;
use crate::model::evaluate::evaluate_body;
use crate::model::prescribed::prescribe;
use crate::model::state::State;
use crate::sqp::run::Run;

constants! {
    /// Solutions with the factor: the second takes the shift's error off.
    const PASSES: usize = 2;
}

impl Response {
    /// The body under loads and supports of the run's state, without contact.
    pub(super) fn free_under(&mut self, run: &mut Run<'_>) -> Free {
        match self.free.take() {
            Some(free) if free.is_of(&run.state.drive) => free,
            Some(_) | None => free(&run.model, run.state, (&self.body.factor, &mut run.work)),
        }
    }
}

/// u0 and p0 under the drive of the state `at`.
pub(super) fn free(
    model: &Model<'_>,
    at: &State,
    (factor, work): (&BodyFactor, &mut Workspace),
) -> Free {
    let mut state = at.clone();
    state.displacement.fill(0.0);
    state.pressure.fill(0.0);
    state.multiplier.fill(0.0);
    prescribe(model, &at.drive, &mut state.displacement);
    let at_rest = vec![0.0; state.displacement.len()];
    carry(model, &at_rest, &mut state.displacement);
    let mut now = evaluate_body(model, &state, work);
    for _ in 0..PASSES {
        let mut load = std::mem::take(&mut now.force);
        load.extend_from_slice(&now.constraint);
        factor.solve(&mut load, work);
        let (moved, pressure) = load.split_at(state.displacement.len());
        add_scaled(&mut state.displacement, 1.0, moved);
        add_scaled(&mut state.pressure, 1.0, pressure);
        now = evaluate_body(model, &state, work);
    }
    Free {
        drive: state.drive,
        displacement: state.displacement,
        pressure: state.pressure,
        left: Accuracy {
            force: norm(&now.force),
            volume: norm(&now.constraint),
        },
        reaction_norm: now.reaction_norm,
    }
}
