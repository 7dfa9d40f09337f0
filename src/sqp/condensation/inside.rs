//! What the body does inside where an answer was on contact alone, from the load that the state
//! keeps:
//!
//! ```text
//! (u, p) = (u0, p0) - K^-1 (q, 0)   off the surface, where u stays as it is
//! ```
//!
//! A function of that state alone, and nothing that later answers on contact depend on: bits
//! are the same whether and when somebody asked. Cost: one solution with the factor.

use super::free;
use super::kept::{Known, Response};
use super::known::with;
use crate::linalg::Workspace;
use crate::model::Model;
use crate::model::mean_pressure::centre_pressure;
use crate::model::state::State;
use crate::sqp::learned::Learned;
use crate::sqp::run::Run;

/// Makes the state that of the whole body.
pub(crate) fn complete(run: &mut Run<'_>) {
    if run.state.is_whole() {
        return;
    }
    let whole = with(run, |response, run| {
        response.whole(&run.model, run.state, run.work)
    });
    if let Some(whole) = whole {
        *run.state = whole;
    }
}

/// The state of the whole body; none where `state` is that already, or the response is not there.
pub(crate) fn completed(model: &Model<'_>, state: &State, learned: &Learned) -> Option<State> {
    match &learned.response {
        Known::Response(_) if state.is_whole() => None,
        Known::Response(response) => response.whole(model, state, &mut Workspace::new()),
        Known::Nothing | Known::Refused => None,
    }
}

impl Response {
    fn whole(&self, model: &Model<'_>, state: &State, work: &mut Workspace) -> Option<State> {
        let mut moved_by = state.surface_load.clone()?;
        let made;
        let free = match &self.free {
            Some(free) if free.is_of(&state.drive) => free,
            Some(_) | None => {
                made = free::free(model, state, (&self.body.factor, work));
                &made
            }
        };
        let solution = self.body.solution(moved_by.load.to_vec(), work);
        let (moved, pressure) = solution.split_at(state.displacement.len());
        moved_by.is_whole = true;
        let mut whole = State {
            surface_load: Some(moved_by),
            ..state.clone()
        };
        for (unknown, entry) in (0..).zip(&mut whole.displacement) {
            if self.body.columns.place(unknown).is_none() {
                *entry = free.displacement[unknown as usize] - moved[unknown as usize];
            }
        }
        let pressures = free.pressure.iter().zip(pressure);
        let own = whole.pressure.iter_mut().zip(pressures);
        own.for_each(|(own, (free, p))| *own = free - p);
        centre_pressure(model, &mut whole);
        Some(whole)
    }
}
