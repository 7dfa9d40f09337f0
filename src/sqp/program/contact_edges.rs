//! What the factor of a body adds where two closed contacts meet at an angle:
//!
//! ```text
//! G_s = - sum over nodes of an edge  c sum_i (n_i . v)^2,   c = p l,   l = w^((d - 2) / (d - 1))
//! ```
//!
//! n_i the normals of the closed multipliers on the node, p the largest of their pressures, w
//! their weight. The internal pressure takes p (u . n_1) (v . n_2) off along an edge, which the
//! gaps of both faces hold and the areas of neither tell: in the corner of a box that is full at
//! 4,000 shear moduli the body alone has one motion as soft as that, which no Lanczos step finds.
//! A program whose edges stay closed does not see the term; others see as many columns as there
//! are such nodes. Cost: a pass over the closed multipliers.

use std::collections::BTreeMap;

use crate::contact::gap::mean_normals;
use crate::geometry::vector3::{dot, normalised};
use crate::linalg::{SparseRows, SparseRowsBuilder};
use crate::model::Model;
use crate::model::state::State;

constants! {
    /// Cosine of the angle between normals from which on they are of one surface: sides have functions
    /// of their own where it turns by 30 degrees (0.87).
    const ALIKE: f64 = 0.9;
}

/// The closed contacts of a node.
#[derive(Default)]
struct ContactEdge {
    /// Unit normals `[contacts][3]`.
    normals: Vec<[f64; 3]>,
    /// Largest pressure, and the largest weight.
    pressure: f64,
    weight: f64,
}

impl ContactEdge {
    /// Whether two of the normals are of different faces.
    fn is_bent(&self) -> bool {
        let pairs = self.normals.windows(2);
        pairs.into_iter().any(|pair| dot(pair[0], pair[1]) < ALIKE)
    }
}

/// G_s on free entries `[displacement, displacement]`, as what is taken off the stiffness; none
/// without such edges.
pub(super) fn contact_edges(model: &Model<'_>, state: &State) -> Option<SparseRows> {
    let c = model.prepared.space.components;
    let mut rows = vec![Vec::new(); state.displacement.len()];
    let mut bent = of_nodes(model, state);
    bent.retain(|_, contact_edge| contact_edge.is_bent());
    for (node, contact_edge) in &bent {
        let power = (c as f64 - 2.0) / (c as f64 - 1.0);
        let size = contact_edge.pressure * contact_edge.weight.powf(power);
        let first = *node as usize * c;
        let is_free = |k: usize| !model.prepared.is_held[first + k];
        for i in (0..c).filter(|&i| is_free(i)) {
            for j in (0..c).filter(|&j| is_free(j)) {
                let sum: f64 = contact_edge.normals.iter().map(|n| n[i] * n[j]).sum();
                rows[first + i].push(((first + j) as u32, -size * sum));
            }
        }
    }
    (!bent.is_empty()).then(|| {
        let mut builder = SparseRowsBuilder::new(state.displacement.len());
        rows.iter_mut().for_each(|row| builder.push_row(row));
        model.prepared.held.project_matrix(builder.finish())
    })
}

/// The closed contacts of the nodes.
fn of_nodes(model: &Model<'_>, state: &State) -> BTreeMap<u32, ContactEdge> {
    let body = model.deformed(&state.displacement);
    let mut nodes: BTreeMap<u32, ContactEdge> = BTreeMap::new();
    let met = model.placed(&state.drive);
    for (interface, met) in met.filter(|(_, met)| met.is_by_points()) {
        let surface = &interface.surface;
        let normals = mean_normals(&body, surface, &met);
        let multipliers = interface.own(&state.multiplier);
        let status = interface.own(&state.status);
        let carriers = (0..).zip(&surface.carriers);
        let of_carriers = carriers.flat_map(|(function, &node)| {
            let of = surface.shares.of(function);
            of.map(move |(m, _)| (node, m as usize))
        });
        for (node, m) in of_carriers.filter(|&(_, m)| status[m].is_closed()) {
            if let Some(normal) = normalised(normals[m]) {
                let contact_edge = nodes.entry(node).or_default();
                contact_edge.normals.push(normal);
                contact_edge.pressure = contact_edge.pressure.max(multipliers[m].abs());
                contact_edge.weight = contact_edge.weight.max(surface.weights[m]);
            }
        }
    }
    nodes
}
