//! The force that supports and obstacles exert at every node, as codes exchange it that meet
//! at a surface:
//!
//! ```text
//! F_a = (A u + B^T p + C^T l - f)_a on what supports hold,   less (C^T l)_a everywhere
//! ```
//!
//! Forces belong to the Lagrange functions of the nodes, which sum to one: the sum over the
//! nodes of a support is its reaction, the sum over all nodes that of all supports and
//! obstacles. Follower pressures are loads, and so part of f. What the axis of a body of
//! revolution holds is nobody's. Non-dimensional, hierarchical but for the field. Cost: one
//! product with the operator and one pass over the contact surfaces.

use crate::linalg::vector::add_scaled;
use crate::linalg::{LinearOperator, Workspace};
use crate::model::Model;
use crate::model::evaluate::external_force;
use crate::model::internal::internal;
use crate::model::joined::Joined;
use crate::model::state::State;

/// Forces of supports and obstacles on all nodes `[nodes * components]`, non-dimensional.
pub(crate) fn nodal_force(model: &Model<'_>, state: &State) -> Vec<f64> {
    let contact = contact_force(model, state);
    let inside = internal(model, state, &mut Workspace::new()).force;
    let space = &model.prepared.space;
    let reaction = space.node_forces(&reaction(model, state, inside, &contact));
    let mut force = space.node_forces(&contact);
    force.iter_mut().for_each(|value| *value = -*value);
    let supports = model.plan.problem.resolved.supports.len();
    for &(unknown, support) in &model.plan.problem.held {
        if usize::from(support) < supports {
            force[unknown as usize] += reaction[unknown as usize];
        }
    }
    let c = space.components;
    for one in &model.plan.problem.held_nodes {
        let first = one.held.node as usize * c;
        for own in one.reactions(c, &reaction) {
            (0..c).for_each(|i| force[first + i] += own[i]);
        }
    }
    force
}

/// What holds the body in held rows `[displacement]`: the force of the body itself,
/// `internal`, and that against `contact` less the loads.
pub(crate) fn reaction(
    model: &Model<'_>,
    state: &State,
    internal: Vec<f64>,
    contact: &[f64],
) -> Vec<f64> {
    let mut reaction = internal;
    add_scaled(&mut reaction, -1.0, &external_force(model, state));
    add_scaled(&mut reaction, 1.0, contact);
    reaction
}

/// C^T l with held columns kept `[displacement]`: what the body exerts on obstacles and guides.
pub(crate) fn contact_force(model: &Model<'_>, state: &State) -> Vec<f64> {
    let body = model.deformed(&state.displacement);
    let mut contact = vec![0.0; state.displacement.len()];
    let free = vec![false; contact.len()];
    let mut joined = Joined::new(state.multiplier.len());
    for (interface, met) in model.placed(&state.drive) {
        joined.add(interface, met.linearise(&body, &interface.surface, &free));
    }
    if let Some(friction) = &model.interfaces.friction {
        joined.add_friction(friction, friction.linearised(model, state, &free));
    }
    let (_, coupling) = joined.finish(contact.len());
    coupling.apply_transposed(&state.multiplier, &mut contact, &mut Workspace::new());
    contact
}
