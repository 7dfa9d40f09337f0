//! Contact pressure at the displacement nodes of all surfaces, and what lies across contacts between
//! bodies.
//!
//! On a surface that carries multipliers coefficients of quadratic Bernstein functions; where a node has
//! several functions of one obstacle, on the sides of an edge, the largest. On a surface that another one
//! carries the pressure of, what the coefficients are, taken straight between nodes, at the nearest
//! place of the carrier ([`crate::pairs::opposite`]): where meshes match the same coefficients. Shapes
//! `[nodes]`, non-dimensional. Cost: a pass over the surfaces; of pairs a search.

use super::Model;
use super::interfaces::Interface;
use super::state::State;
use crate::fluid::across::Across;
use crate::fluid::surface::FluidSurface;
use crate::pairs::opposite::{Opposite, opposite};

/// Contact at the nodes.
pub(crate) struct NodalContact {
    /// Coefficients of the pressure of all obstacles and bodies.
    pub(crate) pressure: Vec<f64>,
    /// Nodes of surfaces that do not carry, with the pressure there, of all contacts between bodies.
    opposite: Vec<(Opposite, f64)>,
}

impl NodalContact {
    /// At the state.
    pub(crate) fn at(model: &Model<'_>, state: &State) -> Self {
        Self::of(model, &contacts(model, state))
    }

    /// Of all contacts.
    pub(crate) fn of(model: &Model<'_>, contacts: &[OneContact<'_>]) -> Self {
        let mut pressure = vec![0.0; model.prepared.space.nodes()];
        for one in contacts {
            let sums = pressure.iter_mut().zip(&one.pressure);
            sums.for_each(|(sum, own)| *sum += own);
        }
        let opposite = contacts.iter().flat_map(|one| one.opposite.clone());
        Self {
            pressure,
            opposite: opposite.collect(),
        }
    }

    /// What of it lies across on the surface of a fluid.
    pub(crate) fn across(&self, surface: &FluidSurface) -> Vec<Across> {
        let place = |node: &u32| surface.nodes.binary_search(node).ok();
        let all = self.opposite.iter().filter_map(|(one, pressure)| {
            let on = one.on.iter();
            let on = on.filter_map(|(node, share)| Some((place(node)?, *share)));
            let on: Vec<(usize, f64)> = on.collect();
            (!on.is_empty()).then_some(Across {
                place: place(&one.node)?,
                on,
                is_pressed: *pressure > 0.0,
            })
        });
        all.collect()
    }
}

/// One contact at the nodes.
pub(crate) struct OneContact<'a> {
    /// Of the obstacle, or of the contact between bodies.
    pub(crate) name: &'a str,
    /// Coefficients of its pressure.
    pub(crate) pressure: Vec<f64>,
    opposite: Vec<(Opposite, f64)>,
}

/// All contacts of obstacles and between bodies.
pub(crate) fn contacts<'a>(model: &Model<'a>, state: &State) -> Vec<OneContact<'a>> {
    let interfaces = model.interfaces.list.iter();
    let interfaces = interfaces.filter(|interface| interface.is_contact());
    let obstacles = model.plan.problem.obstacles.len();
    let pairs = &model.plan.problem.pairs;
    let all = interfaces.enumerate().map(|(number, interface)| {
        let other = number.checked_sub(obstacles).and_then(|k| pairs.get(k));
        let own = coefficients_of(model, state, interface);
        let opposite = other.map_or_else(Vec::new, |pair| {
            let found = opposite_to(model, state, [&interface.facets, &pair.other]);
            let with = |one: Opposite| {
                let pressure = pressure_on(&one, &own);
                (one, pressure)
            };
            found.into_iter().map(with).collect()
        });
        let mut pressure = own;
        for (one, value) in &opposite {
            pressure[one.node as usize] += value;
        }
        OneContact {
            name: &interface.name,
            pressure,
            opposite,
        }
    });
    all.collect()
}

/// Pressure on a node by the coefficients of the carrier.
fn pressure_on(one: &Opposite, coefficients: &[f64]) -> f64 {
    let on = one.on.iter().filter(|_| one.is_before);
    on.map(|&(node, share)| share * coefficients[node as usize])
        .sum()
}

/// What lies opposite to the facets of the second surface on those of the first one.
fn opposite_to(model: &Model<'_>, state: &State, sides: [&[u32]; 2]) -> Vec<Opposite> {
    let space = &model.prepared.space;
    let scale = model.plan.problem.units.coordinate_scale;
    let moved = space.node_values(&state.displacement);
    let place = |node: u32| {
        let mut place = space.node_place(model.mesh, node).map(|x| x * scale);
        let moved = moved.chunks_exact(space.components).nth(node as usize);
        let pairs = place.iter_mut().zip(moved.unwrap_or_default());
        pairs.for_each(|(x, u)| *x += u);
        place
    };
    opposite((model.mesh, space), sides, &place)
}

fn coefficients_of(model: &Model<'_>, state: &State, interface: &Interface) -> Vec<f64> {
    let own = interface.coefficients(&state.multiplier);
    let mut at_nodes = vec![0.0_f64; model.prepared.space.nodes()];
    for face in &interface.surface.faces {
        let values: Vec<f64> = face.functions.iter().map(|&k| own[k as usize]).collect();
        let values = elevated(values, face.corners.len());
        for (&node, value) in face.nodes.iter().zip(values) {
            let known = &mut at_nodes[node as usize];
            *known = known.max(value);
        }
    }
    at_nodes
}

/// Quadratic Bernstein coefficients of a face from its own ones; hats have the mean of their ends on
/// edges.
fn elevated(mut values: Vec<f64>, corners: usize) -> Vec<f64> {
    if values.len() == corners {
        for a in 0..corners {
            for b in a + 1..corners {
                values.push(0.5 * (values[a] + values[b]));
            }
        }
    }
    values
}
