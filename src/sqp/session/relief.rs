//! By how much a body starts inside its obstacles. It is let in by that much, and
//! pushed out over the parts of the first increment:
//!
//! ```text
//! g_i + (1 - t) max(-g_i(0), 0) >= 0,   t from 0 to 1
//! ```

use crate::contact::gap::evaluate_gaps;
use crate::linalg::vector::scale;
use crate::sqp::drive::Drive;
use crate::sqp::evaluate::Context;
use crate::sqp::state::State;

/// Penetration at the start, over the body's length, that one part resolves.
const LARGEST_RELIEF: f64 = 0.05;

/// By how much a start lies inside its obstacles.
pub(super) struct Relief {
    /// Weighted penetration `[multipliers]`; empty where one part resolves it.
    pub(super) penetration: Vec<f64>,
    /// Deepest, non-dimensional.
    depth: f64,
}

impl Relief {
    pub(super) fn of(context: &Context<'_>, state: &State, start: &Drive) -> Self {
        let mut relief = Self {
            penetration: Vec::new(),
            depth: 0.0,
        };
        if context.prepared.strain.is_none() {
            return relief;
        }
        let body = context.deformed(&state.displacement);
        let length = context.plan.units.length;
        let obstacles = context.interfaces.obstacles(start, length);
        for (interface, obstacle) in context.interfaces.list.iter().zip(&obstacles) {
            let (gaps, _) = evaluate_gaps(&body, &interface.surface, obstacle);
            for (gap, weight) in gaps.iter().zip(&interface.surface.weights) {
                relief.depth = relief.depth.max(-gap / weight);
                relief.penetration.push((-gap).max(0.0));
            }
        }
        if relief.depth <= LARGEST_RELIEF {
            relief.penetration.clear();
        }
        relief
    }

    pub(super) fn first_part(&self) -> f64 {
        match self.penetration.is_empty() {
            true => 1.0,
            false => LARGEST_RELIEF / self.depth,
        }
    }

    /// What is still allowed where a fraction of the way is done.
    pub(super) fn left(&self, fraction: f64) -> Vec<f64> {
        let mut left = self.penetration.clone();
        scale(&mut left, 1.0 - fraction);
        left
    }
}
