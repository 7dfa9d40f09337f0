//! Fluids at a state: what drives them, and their load
//!
//! ```text
//! f(v) = - sum over fluids q int w n . v da,   w = sum of s_j psi_j
//! ```
//!
//! over the deformed faces for bodies of finite strain, over the undeformed ones for linear bodies;
//! s_j one where a node is wet, between bodies the share that is ([`crate::fluid`]),
//! psi quadratic Bernstein functions, so that w falls from one to zero within the facets of the
//! front. The contact pressures of the state are what obstacles and bodies press beyond the fluid. All is
//! non-dimensional. Cost: that of [`crate::assembly::follower`] on the facets that are wet; nothing
//! without fluids.

use std::borrow::Cow;

use super::Model;
use super::drive::Drive;
use super::nodal_contact::NodalContact;
use super::pressures::pressed;
use super::state::State;
use crate::assembly::follower::{
    FollowerPressure, PressedBody, PressureValues, add_follower_load, follower_sum,
    follower_tangent,
};
use crate::fluid::across::{Across, joined};
use crate::fluid::front::Front;
use crate::fluid::surface::FluidSurface;
use crate::linalg::SparseRows;
use crate::plan::Plan;

/// Of each fluid that presses somewhere: its place among all, and the pressure at the nodes
/// `[nodes]`, non-dimensional Bernstein coefficients.
fn nodal_pressures(model: &Model<'_>, state: &State) -> Vec<(usize, Vec<f64>)> {
    let problem = &model.plan.problem;
    let all = state.drive.fluids.iter().enumerate();
    let pressing = all.filter(|(_, drive)| drive.pressure != 0.0);
    let nodal = pressing.map(|(index, drive)| {
        let pressure = drive.pressure / problem.units.stress;
        (index, at_wet_nodes(model, state, index, pressure))
    });
    nodal.collect()
}

/// `value` at the nodes that one fluid wets, zero at all others `[nodes]`.
fn at_wet_nodes(model: &Model<'_>, state: &State, index: usize, value: f64) -> Vec<f64> {
    let mut all = vec![0.0; model.prepared.space.nodes()];
    let nodes = model.plan.problem.fluid_surfaces[index].nodes.iter();
    for (&node, share) in nodes.zip(state.share_of_fluid(index)) {
        all[node as usize] = value * share;
    }
    all
}

/// What presses: facets with the pressure at all nodes.
fn follower<'a>(model: &Model<'a>, nodal: &'a [(usize, Vec<f64>)]) -> Vec<FollowerPressure<'a>> {
    let fluids = &model.plan.problem.resolved.fluids;
    let pressures = nodal.iter().map(|(index, own)| FollowerPressure {
        facets: &fluids[*index].facets,
        pressure: PressureValues::Nodes(own),
    });
    pressures.collect()
}

/// The displacement by which the pressed faces move: none of a linear body's.
fn moved<'a>(model: &Model<'_>, state: &'a State) -> &'a [f64] {
    if model.is_rubber() {
        &state.displacement
    } else {
        &[]
    }
}

/// Adds the load of all fluids to `force` `[displacement]`.
pub(crate) fn add_fluids(model: &Model<'_>, state: &State, force: &mut [f64]) {
    if state.drive.has_fluid_pressure() {
        let nodal = nodal_pressures(model, state);
        let body = pressed(model, moved(model, state));
        add_follower_load(&body, &follower(model, &nodal), force);
    }
}

/// Force of one fluid `[3]` and the area that it wets, non-dimensional.
pub(crate) fn fluid_load(model: &Model<'_>, state: &State, index: usize) -> ([f64; 3], f64) {
    let space = &model.prepared.space;
    let body = pressed(model, moved(model, state));
    let wet = [(index, at_wet_nodes(model, state, index, 1.0))];
    let wet = follower(model, &wet);
    let mut load = vec![0.0; space.displacement_unknowns()];
    add_follower_load(&body, &wet, &mut load);
    let pressure = state.drive.fluids[index].pressure / model.plan.problem.units.stress;
    let mut force = [0.0; 3];
    // Hats sum to one: the rows of the vertices sum to the whole force.
    for row in load.chunks_exact(space.components).take(space.vertices) {
        force
            .iter_mut()
            .zip(row)
            .for_each(|(sum, f)| *sum += pressure * f);
    }
    (force, follower_sum(&body, &wet))
}

/// What the motion `y` `[displacement]` does with the pressures of fluids on each facet that a front
/// crosses: with what presses there or what does not yet, whichever is more; with its cell.
pub(crate) fn front_works(model: &Model<'_>, state: &State, y: &[f64]) -> Vec<(usize, f64)> {
    let problem = &model.plan.problem;
    let body = pressed(model, moved(model, state));
    let (mut works, mut load) = (Vec::new(), vec![0.0; y.len()]);
    for (index, wet) in nodal_pressures(model, state) {
        let surface = &problem.fluid_surfaces[index];
        let mut all = wet.clone();
        let pressure = state.drive.fluids[index].pressure / problem.units.stress;
        (surface.nodes.iter()).for_each(|&node| all[node as usize] = pressure);
        let facets = problem.resolved.fluids[index].facets.iter();
        let crossed = facets.zip(&surface.facets).filter(|(_, nodes)| {
            let mut own = nodes.iter().map(|&place| state.wet[index][place as usize]);
            let first = own.next();
            own.any(|other| Some(other) != first)
        });
        for (&facet, _) in crossed {
            let [pressed, whole] =
                [&wet, &all].map(|nodal| work_on(&body, (facet, nodal), y, &mut load));
            let cell = model.mesh.facet_cell(facet as usize).0;
            works.push((cell, pressed.abs().max((whole - pressed).abs())));
        }
    }
    works
}

/// What `y` does with pressures at nodes on one facet; `load` is zero before and after.
fn work_on(
    body: &PressedBody<'_>,
    (facet, nodal): (u32, &[f64]),
    y: &[f64],
    load: &mut [f64],
) -> f64 {
    let c = body.space.components;
    let one = FollowerPressure {
        facets: &[facet],
        pressure: PressureValues::Nodes(nodal),
    };
    add_follower_load(body, &[one], load);
    let nodes = body.space.facet_nodes(body.mesh.facet(facet as usize));
    let entries = nodes
        .iter()
        .flat_map(|&node| node as usize * c..(node as usize + 1) * c);
    entries
        .map(|entry| std::mem::take(&mut load[entry]) * y[entry])
        .sum()
}

/// What the fluids take off the stiffness at a state; none where none follows the body.
pub(crate) fn fluid_tangent(model: &Model<'_>, state: &State) -> Option<SparseRows> {
    let prepared = &model.prepared;
    let tangent = wetted_tangent(model, state, &prepared.is_held)?;
    Some(prepared.held.project_matrix(tangent))
}

/// The same without rows and columns of what is `held` `[displacement unknowns]`.
pub(crate) fn wetted_tangent(
    model: &Model<'_>,
    state: &State,
    held: &[bool],
) -> Option<SparseRows> {
    let follows = model.is_rubber() && state.drive.has_fluid_pressure();
    follows.then(|| {
        let nodal = nodal_pressures(model, state);
        let body = pressed(model, moved(model, state));
        follower_tangent(&body, &follower(model, &nodal), held)
    })
}

/// Contact pressure of all obstacles and bodies over all that a fluid can reach, in the mean, non-dimensional.
pub(crate) fn mean_contact(model: &Model<'_>, state: &State, index: usize) -> f64 {
    let contact = NodalContact::at(model, state).pressure;
    let body = pressed(model, moved(model, state));
    let sum = |nodal: Vec<f64>| follower_sum(&body, &follower(model, &[(index, nodal)]));
    let ones = vec![1.0; contact.len()];
    sum(contact) / sum(ones)
}

/// Nodes that fluid `index` must not reach: those that must stay dry, and those that another fluid wets
/// `[nodes of the surface]`.
pub(crate) fn barred(model: &Model<'_>, state: &State, index: usize) -> Vec<bool> {
    let surfaces = &model.plan.problem.fluid_surfaces;
    let own = &surfaces[index];
    let mut barred = own.dry.clone();
    let others = surfaces.iter().zip(&state.wet).enumerate();
    for (_, (surface, wet)) in others.filter(|(other, _)| *other != index) {
        for (node, _) in surface.nodes.iter().zip(wet).filter(|(_, wet)| **wet) {
            if let Ok(place) = own.nodes.binary_search(node) {
                barred[place] = true;
            }
        }
    }
    barred
}

/// What fluid `index` finds on its surface `[nodes of the surface]`, non-dimensional.
pub(crate) struct Met<'a> {
    /// The surface, its parts joined by what lies across.
    surface: Cow<'a, FluidSurface>,
    across: Vec<Across>,
    /// Coefficients of the contact pressure, what the fluid bears left out.
    pub(crate) contact: Vec<f64>,
    /// Pressure of contact and fluid together at the nodes.
    pub(crate) total: Vec<f64>,
    /// Nodes that it must not reach.
    pub(crate) dry: Vec<bool>,
}

impl<'a> Met<'a> {
    /// At the state.
    pub(crate) fn at(model: &Model<'a>, state: &State, index: usize) -> Self {
        let surface = &model.plan.problem.fluid_surfaces[index];
        let fluid = state.drive.fluids[index].pressure / model.plan.problem.units.stress;
        let met = NodalContact::at(model, state);
        let contact = surface.own(&met.pressure);
        let pairs = contact.iter().zip(state.share_of_fluid(index));
        let sums = pairs.map(|(contact, share)| contact + share * fluid);
        let total = surface.values(&sums.collect::<Vec<_>>());
        let dry = barred(model, state, index);
        let across = met.across(surface);
        Self {
            surface: joined(surface, &across),
            across,
            contact,
            total,
            dry,
        }
    }

    /// The front of fluid `index` there, under `drive`.
    pub(crate) fn front<'b>(&'b self, plan: &Plan, index: usize, drive: &Drive) -> Front<'b> {
        let problem = &plan.problem;
        let pressure = drive.fluids[index].pressure;
        let threshold = problem.resolved.fluids[index].threshold.unwrap_or(pressure);
        Front {
            surface: &self.surface,
            across: &self.across,
            dry: &self.dry,
            contact: &self.contact,
            total: &self.total,
            threshold: threshold / problem.units.stress,
        }
    }
}
