//! By how much a body starts inside its obstacles. It is pushed out at once, and where that fails
//! let in by that much and pushed out over the parts of the first increment:
//!
//! ```text
//! int psi_i (d + (1 - t) delta) da >= 0,   delta_i = max(-g_i(0) / w_i, 0),   t from 0 to 1
//! ```

use std::sync::Arc;

use crate::linalg::vector::{largest, scale};
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::state::State;

/// By how much a start lies inside its obstacles.
pub(crate) struct InitialPenetration {
    /// Mean penetration `[multipliers]`, in units of the scaled body; empty without any.
    penetration: Vec<f64>,
}

impl InitialPenetration {
    /// That of `state` on the obstacles as `start` has them; none for linear bodies.
    pub(crate) fn of(model: &Model<'_>, state: &State, start: &Drive) -> Self {
        let mut found = Self {
            penetration: vec![0.0; state.multiplier.len()],
        };
        if !model.is_rubber() {
            found.penetration.clear();
            return found;
        }
        let body = model.deformed(&state.displacement);
        for (interface, obstacle) in model.placed(start) {
            if !interface.is_contact() {
                // A support moves its surface along.
                continue;
            }
            let (gaps, _) = obstacle.gaps(&body, &interface.surface);
            let weighted = gaps.iter().zip(&interface.surface.weights);
            for (place, (gap, weight)) in interface.places().zip(weighted) {
                let depth = (-gap / weight).max(0.0);
                found.penetration[place] = found.penetration[place].max(depth);
            }
        }
        if largest(&found.penetration) <= 0.0 {
            found.penetration.clear();
        }
        found
    }

    /// None.
    pub(crate) fn none() -> Self {
        Self {
            penetration: Vec::new(),
        }
    }

    /// Whether there is any, so that a body between two parts is still let in.
    pub(crate) fn is_any(&self) -> bool {
        !self.penetration.is_empty()
    }

    /// Depths that are still let be where a fraction of the path is done `[multipliers]`.
    pub(crate) fn left(&self, fraction: f64) -> Arc<[f64]> {
        let mut left = self.penetration.clone();
        scale(&mut left, 1.0 - fraction);
        left.into()
    }
}
