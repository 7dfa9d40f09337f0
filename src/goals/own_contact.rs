//! A surface in contact at a state, with an obstacle or another body, and the rows of its gaps and
//! slips: what goals on it are made of.
//!
//! ```text
//! f = -C^T l,   C w,   K = -d(C^T l)/du
//! ```
//!
//! l its pressures and its tractions of friction. Held columns among them. Non-dimensional. Cost:
//! one pass over the surface.

use crate::contact::curvature;
use crate::linalg::SparseRows;
use crate::model::Model;
use crate::model::interfaces::Interface;
use crate::model::placed::Placed;
use crate::model::state::State;

/// A surface in contact with the rows of its gaps and slips, held columns among them.
pub(super) struct OwnContact<'a> {
    interface: &'a Interface,
    /// What it meets.
    pub(super) met: Placed,
    /// Its place among all.
    index: usize,
    /// Places of its multipliers, and their rows of C.
    rows: Vec<(usize, Vec<(u32, f64)>)>,
    /// Displacement unknowns.
    size: usize,
}

impl<'a> OwnContact<'a> {
    /// Of the interface of that number: they begin with the obstacles, in their order, then come
    /// contacts between bodies.
    pub(super) fn new(model: &Model<'a>, state: &State, index: usize) -> Option<Self> {
        let free = vec![false; state.displacement.len()];
        let mut placed = model.placed(&state.drive);
        let (interface, met) = placed.nth(index)?;
        let body = model.deformed(&state.displacement);
        let linearised = met.linearise(&body, &interface.surface, &free);
        let mut rows: Vec<_> = interface.places().zip(linearised.rows).collect();
        if let Some(friction) = &model.interfaces.friction {
            let width = friction.components.count();
            let all = friction.linearised(model, state, &free).rows.into_iter();
            let tractions = all.enumerate().filter(|(place, _)| {
                let point = friction.points.get(place / width);
                point.is_some_and(|point| point.obstacle == index)
            });
            rows.extend(tractions.map(|(place, row)| (friction.first + place, row)));
        }
        Some(Self {
            interface,
            met,
            index,
            rows,
            size: free.len(),
        })
    }

    /// -C^T l: what the obstacle exerts on the body, or two bodies on each other.
    pub(super) fn force(&self, state: &State) -> Vec<f64> {
        let mut force = vec![0.0; self.size];
        for (place, row) in &self.rows {
            for (unknown, value) in row {
                force[*unknown as usize] -= state.multiplier[*place] * value;
            }
        }
        force
    }

    /// Adds `factor` C w to `all` multipliers.
    pub(super) fn add_work(&self, factor: f64, motion: &[f64], all: &mut [f64]) {
        for (place, row) in &self.rows {
            let terms = row
                .iter()
                .map(|(unknown, value)| value * motion[*unknown as usize]);
            all[*place] += factor * terms.sum::<f64>();
        }
    }

    /// K of its gaps under its pressure and of its tangents under its tractions.
    pub(super) fn curvature(&self, model: &Model<'_>, state: &State) -> SparseRows {
        let body = model.deformed(&state.displacement);
        let pressure = self.interface.own(&state.multiplier);
        let free = vec![false; self.size];
        let own = match self.interface.pair() {
            Some(pair) => pair.curvature(&body, (&self.interface.surface, &pressure), &free),
            None => {
                let surface = (&self.interface.surface, &self.met, &pressure[..]);
                curvature(&body, &[surface], &free)
            }
        };
        let Some(friction) = &model.interfaces.friction else {
            return own;
        };
        let mut alone = state.clone();
        let width = friction.components.count();
        for (number, point) in friction.points.iter().enumerate() {
            if point.obstacle != self.index {
                let first = friction.first + number * width;
                alone.multiplier[first..first + width].fill(0.0);
            }
        }
        match friction.turning_of((model, &alone), &free) {
            Some(turning) => own.plus(&turning.geometric),
            None => own,
        }
    }
}
