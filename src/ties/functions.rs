//! Which functions of a carrier have a multiplier of a component of the displacement.
//!
//! A function goes to its neighbours, so that all still add up to one, where
//! * its node is held, or another condition acts there: it would be one more than the motions left;
//! * its node is a corner, where the traction jumps: the functions of either side end before it;
//! * less than half of it has a partner.
//!
//! Without, the equations of a tie depend on each other, or nearly so. Cost: one pass over the functions.

use std::collections::BTreeMap;

use super::seam::Seam;
use crate::contact::ContactSurface;
use crate::contact::layout::Layout;
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Share of a function that has a partner below which it has no multiplier.
const LEAST_COVERED: f64 = 0.5;

/// What takes multipliers from functions.
#[derive(Clone, Copy)]
pub struct Lost<'a> {
    /// What functions cover.
    pub seam: &'a Seam,
    /// Faces and functions of the carrier.
    pub surface: &'a ContactSurface,
    /// Whether a node is held, or another condition acts there.
    pub is_taken: &'a dyn Fn(u32) -> bool,
}

impl Lost<'_> {
    /// Whether less than half of a function has a partner.
    fn is_short(&self, function: usize) -> bool {
        self.seam.covered[function] < LEAST_COVERED * self.surface.weights[function]
    }

    /// The part of what is tied that lies under functions of which less than half has a partner.
    pub fn short_share(&self) -> f64 {
        let covered = &self.seam.covered;
        let all = covered.iter().enumerate();
        let short = all.filter(|(function, _)| self.is_short(*function));
        let short: f64 = short.map(|(_, covered)| covered).sum();
        short / covered.iter().sum::<f64>()
    }
}

/// The functions of the carrier `facets`, laid out by `base`, with their multipliers.
pub fn layout_of(
    (mesh, space): (&Mesh, &TaylorHood),
    (facets, base): (&[u32], &Layout),
    lost: Lost<'_>,
) -> Layout {
    let mut functions_at = BTreeMap::new();
    for node in &base.nodes {
        *functions_at.entry(node).or_insert(0) += 1;
    }
    let is_lost = base
        .nodes
        .iter()
        .enumerate()
        .map(|(k, node)| lost.is_short(k) || functions_at[node] > 1 || (lost.is_taken)(*node));
    let is_lost: Vec<bool> = is_lost.collect();
    base.taken_over((mesh, space, facets), &is_lost)
}
