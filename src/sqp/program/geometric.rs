//! What loads and contacts take off the stiffness of a body:
//!
//! ```text
//! G = load stiffness (pressures that follow the body, a proximal term)
//!   + curvature of the gaps under the contact pressure + turning of tangents under friction
//! ```
//!
//! Cost: one pass over the surfaces under pressure.

use crate::contact::{Advancing, Counterpart, curvature};
use crate::linalg::SparseRows;
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::evaluate::Evaluation;
use crate::model::fluids::fluid_tangent;
use crate::model::interfaces::Interface;
use crate::model::pressures::pressure_tangent;
use crate::model::state::State;

/// The terms, held unknowns left out.
pub(super) struct GeometricStiffness {
    /// Load stiffness `[displacement, displacement]`; none without loads that follow the body.
    pub(super) load: Option<SparseRows>,
    /// That with the curvature of the gaps and the turning of tangents; none where no pressure
    /// bends them.
    pub(super) with_contact: Option<SparseRows>,
    /// Rows of the gaps and slips with the turning of tangents; none where none turn.
    pub(super) rows: Option<SparseRows>,
}

impl GeometricStiffness {
    /// Those at the state, whose residuals are `now`.
    pub(super) fn of(model: &Model<'_>, state: &State, now: &Evaluation) -> Self {
        let held = &model.prepared.held;
        let load = load_stiffness(model, state);
        let friction = model.interfaces.friction.as_ref();
        let turning = friction.and_then(|friction| friction.turning(model, state));
        let (rows, turned) = match turning {
            Some(turning) => {
                let rows = now.coupling.plus(&held.project_columns(turning.rows));
                (Some(rows), Some(held.project_matrix(turning.geometric)))
            }
            None => (None, None),
        };
        let others = [load.as_ref(), turned.as_ref()];
        let with_contact = curvature_of(model, state, now.last_drive()).map(|own| {
            let others = others.into_iter().flatten();
            others.fold(own, |sum, term| sum.plus(term))
        });
        Self {
            load,
            with_contact,
            rows,
        }
    }

    /// All of it; none where there is none.
    pub(super) fn all(&self) -> Option<&SparseRows> {
        self.with_contact.as_ref().or(self.load.as_ref())
    }
}

/// What pressures that follow the body and a pull to an earlier state take off the
/// stiffness; none where there is neither.
fn load_stiffness(model: &Model<'_>, state: &State) -> Option<SparseRows> {
    let proximal = model.conditions.proximal.as_ref();
    let terms = [
        pressure_tangent(model, state),
        fluid_tangent(model, state),
        proximal.map(|proximal| proximal.stiffness()),
    ];
    let terms = terms.into_iter().flatten();
    terms.reduce(|sum, term| sum.plus(&term))
}

/// Curvature of the gaps of surfaces on what they meet, under the present contact pressure.
fn curvature_under<C: Counterpart>(
    model: &Model<'_>,
    state: &State,
    met: &[(&Interface, C)],
) -> SparseRows {
    let pressures = met.iter();
    let pressures = pressures.map(|(interface, _)| interface.own(&state.multiplier));
    let pressures: Vec<_> = pressures.collect();
    let surfaces = met.iter().zip(&pressures);
    let surfaces = surfaces.map(|((interface, met), own)| (&interface.surface, met, &own[..]));
    let surfaces: Vec<_> = surfaces.collect();
    let body = model.deformed(&state.displacement);
    curvature(&body, &surfaces, &model.prepared.is_held)
}

/// Curvature of the gaps under the present contact pressure, of tools that have moved on from
/// `last`; none where it vanishes.
fn curvature_of(model: &Model<'_>, state: &State, last: Option<&Drive>) -> Option<SparseRows> {
    let under_pressure = state.multiplier.iter().any(|&l| l != 0.0);
    if model.is_linear() || !under_pressure {
        return None;
    }
    let own = match last {
        None => {
            let placed = model.placed(&state.drive);
            let placed: Vec<_> = placed.filter(|(one, _)| one.is_by_points()).collect();
            curvature_under(model, state, &placed)
        }
        Some(last) => {
            let placed = model.placed_from(state, last);
            let tools = placed.iter().filter(|(one, ..)| one.is_by_points());
            let tools = tools.map(|(interface, now, before)| {
                let before = before.as_ref();
                (*interface, Advancing { now, before })
            });
            curvature_under(model, state, &tools.collect::<Vec<_>>())
        }
    };
    let own = match curvature_between_bodies(model, state) {
        Some(pairs) => own.plus(&pairs),
        None => own,
    };
    Some(model.prepared.held.project_matrix(own))
}

/// Curvature of the gaps between bodies under the present contact pressure; none where no two
/// bodies meet.
pub(super) fn curvature_between_bodies(model: &Model<'_>, state: &State) -> Option<SparseRows> {
    let body = model.deformed(&state.displacement);
    let pairs = model.interfaces.list.iter().filter_map(|interface| {
        let pressures = interface.own(&state.multiplier);
        let own = (&interface.surface, &pressures[..]);
        Some(
            interface
                .pair()?
                .curvature(&body, own, &model.prepared.is_held),
        )
    });
    pairs.reduce(|sum, one| sum.plus(&one))
}
