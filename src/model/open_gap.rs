//! What of a surface is open to a fluid at a state: deformed places of its nodes, how far they are from
//! the nearest obstacle that they may touch, and what flows through ([`crate::fluid::flow`]).
//!
//! A node is closed where contact presses on it, or where an obstacle is no farther than zero. Cost:
//! a distance a node and obstacle, and one sparse factor.

use super::Model;
use super::nodal_contact::NodalContact;
use super::state::State;
use crate::fluid::flow::{Breadth, OpenGap};
use crate::obstacle::Obstacle;
use crate::scene::SceneKind;

/// Deformed places of the nodes of a fluid's surface `[nodes of the surface]`, non-dimensional.
pub(crate) fn places(model: &Model<'_>, state: &State, index: usize) -> Vec<[f64; 3]> {
    let space = &model.prepared.space;
    let nodal = space.node_values(&state.displacement);
    let scale = model.plan.problem.units.coordinate_scale;
    let nodes = model.plan.problem.fluid_surfaces[index].nodes.iter();
    let places = nodes.map(|&node| {
        let mut place = space.node_place(model.mesh, node).map(|x| x * scale);
        let moved = &nodal[node as usize * space.components..][..space.components];
        place.iter_mut().zip(moved).for_each(|(x, u)| *x += u);
        place
    });
    places.collect()
}

/// What flows of fluid `index` for a unit of its pressure through what is open at the state, volume
/// over time and stress in the caller's units; none without a viscosity.
pub(crate) fn conductance(model: &Model<'_>, state: &State, index: usize) -> Option<f64> {
    let problem = &model.plan.problem;
    let viscosity = problem.resolved.fluids[index].viscosity?;
    let surface = &problem.fluid_surfaces[index];
    let places = places(model, state, index);
    let gaps = gaps(model, state, index, &places);
    let breadth = match problem.resolved.kind {
        SceneKind::Axisymmetric => Breadth::Circumference,
        SceneKind::Solid | SceneKind::PlaneStrain | SceneKind::PlaneStress => Breadth::One,
    };
    let open = OpenGap {
        surface,
        places: &places,
        gaps: &gaps,
        breadth,
    };
    let unit = open.conductance().ok()?;
    Some(unit * problem.units.volume() / viscosity)
}

/// How far the nodes of a fluid's surface are from what each may touch, zero where it is closed
/// `[nodes of the surface]`, non-dimensional; as far as the body is long where nothing may touch it.
fn gaps(model: &Model<'_>, state: &State, index: usize, places: &[[f64; 3]]) -> Vec<f64> {
    let surface = &model.plan.problem.fluid_surfaces[index];
    let mut gaps = vec![1.0_f64; places.len()];
    for (interface, met) in model.placed(&state.drive) {
        let Some(obstacle) = met.obstacle() else {
            continue;
        };
        let faces = interface.surface.faces.iter();
        let mut nodes: Vec<u32> = faces.flat_map(|face| face.nodes.iter().copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let own = nodes
            .iter()
            .filter_map(|node| surface.nodes.binary_search(node).ok());
        for place in own {
            let distance = obstacle.distance(places[place]).distance;
            gaps[place] = gaps[place].min(distance.max(0.0));
        }
    }
    let contact = surface.own(&NodalContact::at(model, state).pressure);
    let pressed = gaps
        .iter_mut()
        .zip(contact)
        .filter(|(_, contact)| *contact > 0.0);
    pressed.for_each(|(gap, _)| *gap = 0.0);
    gaps
}
