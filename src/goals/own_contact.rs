//! An obstacle's surface at a state, with the rows of its gaps: what goals on it are made of.
//!
//! ```text
//! f = -C^T l,   C w,   K = d(l . dg/du)/du
//! ```
//!
//! Held columns among them. Non-dimensional. Cost: one pass over the surface.

use crate::contact::curvature;
use crate::contact::gap::linearise;
use crate::linalg::SparseRows;
use crate::model::Model;
use crate::model::interfaces::Interface;
use crate::model::placed::Placed;
use crate::model::state::State;

/// An obstacle's surface with the rows of its gaps, held columns among them.
pub(super) struct OwnContact<'a> {
    interface: &'a Interface,
    /// What it meets.
    pub(super) met: Placed,
    /// C of its multipliers.
    rows: Vec<Vec<(u32, f64)>>,
    /// Its pressures.
    pressure: Vec<f64>,
    /// Displacement unknowns.
    size: usize,
}

impl<'a> OwnContact<'a> {
    /// Of the obstacle of that number: interfaces begin with the obstacles, in their order.
    pub(super) fn new(model: &Model<'a>, state: &State, index: usize) -> Option<Self> {
        let free = vec![false; state.displacement.len()];
        let mut placed = model.placed(&state.drive);
        let (interface, met) = placed.nth(index)?;
        let body = model.deformed(&state.displacement);
        let linearised = linearise(&body, &interface.surface, &met, &free);
        Some(Self {
            interface,
            met,
            rows: linearised.rows,
            pressure: interface.own(&state.multiplier).into_owned(),
            size: free.len(),
        })
    }

    /// -C^T l: what the obstacle exerts on the body.
    pub(super) fn force(&self) -> Vec<f64> {
        let mut force = vec![0.0; self.size];
        for (row, pressure) in self.rows.iter().zip(&self.pressure) {
            for (unknown, value) in row {
                force[*unknown as usize] -= pressure * value;
            }
        }
        force
    }

    /// Adds `factor` C w to `all` multipliers.
    pub(super) fn add_work(&self, factor: f64, motion: &[f64], all: &mut [f64]) {
        for (place, row) in self.interface.places().zip(&self.rows) {
            let terms = row
                .iter()
                .map(|(unknown, value)| value * motion[*unknown as usize]);
            all[place] += factor * terms.sum::<f64>();
        }
    }

    /// K of its gaps under its pressure.
    pub(super) fn curvature(&self, model: &Model<'_>, state: &State) -> SparseRows {
        let body = model.deformed(&state.displacement);
        let surface = (&self.interface.surface, &self.met, &self.pressure[..]);
        curvature(&body, &[surface], &vec![false; self.size])
    }
}
