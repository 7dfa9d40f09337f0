//! A pull towards an earlier state, which makes a soft or unstable body stiff for a while:
//!
//! ```text
//! E(u) + t / 2 (u - a).M (u - a)
//! ```
//!
//! a the anchor `[displacement]`, M a diagonal mass of unit density, t a weight in shear
//! moduli over the square of the length. A sequence of such minima, each the next one's
//! anchor, is a flow down the energy (R. T. Rockafellar, SIAM J. Control Optim. 14, 1976).
//! Cost: nothing beside the body's.

use std::sync::Arc;

use super::Model;
use crate::linalg::{SparseRows, SparseRowsBuilder};

/// The pull.
#[derive(Clone, Debug)]
pub(crate) struct Proximal {
    /// t.
    pub(crate) weight: f64,
    /// a `[displacement]`.
    pub(crate) anchor: Arc<[f64]>,
    /// M `[displacement]`, zero in held entries.
    pub(crate) mass: Arc<[f64]>,
}

impl Proximal {
    /// Adds - t M (u - a) to `force`.
    pub(crate) fn add_force(&self, displacement: &[f64], force: &mut [f64]) {
        let distances = displacement.iter().zip(&*self.anchor);
        let terms = distances.zip(&*self.mass);
        for (force, ((u, a), mass)) in force.iter_mut().zip(terms) {
            *force -= self.weight * mass * (u - a);
        }
    }

    /// - t M, as something that takes stiffness off.
    pub(crate) fn stiffness(&self) -> SparseRows {
        let mut builder = SparseRowsBuilder::new(self.mass.len());
        for (row, mass) in (0..).zip(&*self.mass) {
            builder.push_row(&mut [(row, -self.weight * mass)]);
        }
        builder.finish()
    }
}

/// M: each cell's volume given to its nodes in equal shares.
pub(crate) fn mass(model: &Model<'_>) -> Vec<f64> {
    let space = &model.prepared.space;
    let c = space.components;
    let mut mass = vec![0.0; space.displacement_unknowns()];
    for (cell, volume) in model.prepared.geometry.volumes.iter().enumerate() {
        let nodes = space.facet_nodes(model.mesh.cell(cell));
        let share = volume / nodes.len() as f64;
        for node in nodes {
            let first = c * node as usize;
            mass[first..first + c].iter_mut().for_each(|m| *m += share);
        }
    }
    super::held::mask(&model.prepared.held, &mut mass);
    mass
}
