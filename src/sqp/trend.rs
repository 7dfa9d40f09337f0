//! How a body of rubber moved over its last equilibria, and where that leads:
//!
//! ```text
//! x(0) + r x[0, -1] + r (r + 1) x[0, -1, -1 - 1/q],   x = (u, p, l)
//! ```
//!
//! (Newton's divided differences; [`super::predictor`] says what r and q are.) Changes
//! of the displacement are in the frame that supports carry along. Where other functions of a contact lend
//! theirs than did before, l stays what it is: a change of what carried for others is none of what
//! carries now. Shapes as in [`State`]. Cost: two changes of the state kept.

use super::rigid_predictor::RigidPredictor;
use crate::linalg::vector::{add_scaled, norm};
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::state::State;
use crate::plan::Plan;

constants! {
    /// Share of the contact pressure that a prediction must leave.
    const FADED: f64 = 0.1;
}

/// Difference of two states.
#[derive(Clone, Debug)]
struct Change {
    /// Change of the displacement `[displacement]`.
    displacement: Vec<f64>,
    /// Change of the pressure `[pressures]`.
    pressure: Vec<f64>,
    /// Change of the multipliers `[multipliers]`.
    multiplier: Vec<f64>,
    /// Which of them lent their functions meanwhile; empty where none did.
    lends: Vec<bool>,
}

impl Change {
    /// The change from the displacement and the multipliers before to the present
    /// state.
    fn between(displacement: &[f64], before: &State, state: &State) -> Self {
        let change = |new: &[f64], old: &[f64]| -> Vec<f64> {
            new.iter().zip(old).map(|(new, old)| new - old).collect()
        };
        Self {
            displacement: change(&state.displacement, displacement),
            pressure: change(&state.pressure, &before.pressure),
            multiplier: change(&state.multiplier, &before.multiplier),
            lends: state.lends(),
        }
    }

    /// Adds `weight` times the change to the state.
    fn add_to(&self, state: &mut State, weight: f64) {
        add_scaled(&mut state.displacement, weight, &self.displacement);
        add_scaled(&mut state.pressure, weight, &self.pressure);
        add_scaled(&mut state.multiplier, weight, &self.multiplier);
    }

    /// Bytes that the three vectors hold.
    fn bytes(&self) -> u64 {
        let numbers = self.displacement.len() + self.pressure.len() + self.multiplier.len();
        (8 * numbers + self.lends.len()) as u64
    }
}

/// How the state moved over the last parts that converged.
#[derive(Clone, Debug)]
pub(crate) struct Trend {
    /// Drive at the start of the last part.
    from: Drive,
    /// Drive at its end.
    to: Drive,
    /// How the state changed over it.
    last: Change,
    /// The change before in the same direction, and how many times longer the last
    /// drive was.
    earlier: Option<(f64, Change)>,
}

impl Trend {
    /// Of a state that went on from `before`, where it had the trend `known`; the
    /// same where nothing drove it on.
    pub(crate) fn noted(
        model: &Model<'_>,
        known: Option<Self>,
        before: &State,
        state: &State,
    ) -> Option<Self> {
        let [from, to] = [&before.drive, &state.drive].map(|drive| drive.felt_by(model.plan));
        if from == to {
            return known;
        }
        let earlier = known.filter(|known| known.to == from);
        let mut earlier = earlier.and_then(|known| {
            let longer = to.continues(&known.from, &known.to);
            let longer = longer.filter(|&longer| longer > 0.0);
            longer.map(|longer| (longer, known.last))
        });
        let mut displacement = before.displacement.clone();
        if let Some(rigid) = RigidPredictor::between(model, &before.drive, &state.drive) {
            rigid.apply(model, &mut displacement);
            if let Some((_, change)) = &mut earlier {
                let components = model.prepared.space.components;
                rigid.turn(components, &mut change.displacement);
            }
        }
        Some(Self {
            from,
            to,
            last: Change::between(&displacement, before, state),
            earlier,
        })
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        let earlier = self
            .earlier
            .as_ref()
            .map_or(0, |(_, change)| change.bytes());
        self.last.bytes() + earlier
    }

    /// Continues `state`, driven from `here`, towards `drive`; whether that is in the
    /// same direction and leaves contact pressure where there is some: that of a body
    /// at the end of contact is rounding, and no measure of itself.
    pub(crate) fn continue_to(
        &self,
        plan: &Plan,
        state: &mut State,
        [here, drive]: [&Drive; 2],
    ) -> bool {
        let Some(further) = drive.continues(&self.from, &self.to) else {
            return false;
        };
        if self.to != *here {
            return false;
        }
        let held = state.multiplier.clone();
        self.last.add_to(state, further);
        if let Some((longer, earlier)) = &self.earlier {
            let bend = further * (further + 1.0) * longer / (1.0 + longer);
            self.last.add_to(state, bend);
            earlier.add_to(state, -bend * longer);
        }
        if !self.lends_like(&state.lends()) {
            state.multiplier.clone_from(&held);
        }
        // Tractions and what supports exert have either sign.
        let pressures = state.multiplier.iter_mut().take(plan.normal_multipliers());
        pressures.for_each(|pressure| *pressure = pressure.max(0.0));
        let before = norm(&held);
        before == 0.0 || norm(&state.multiplier) > FADED * before
    }

    /// Whether all changes are those of multipliers of which the same ones lent their functions.
    fn lends_like(&self, lends: &[bool]) -> bool {
        let earlier = self.earlier.as_ref().map(|(_, change)| change);
        let mut changes = earlier.into_iter().chain([&self.last]);
        changes.all(|change| change.lends == lends)
    }
}
