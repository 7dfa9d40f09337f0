//! From a state to the report of an increment, in the caller's units.

use std::collections::BTreeMap;

use super::counters::{Counters, timed};
use super::errors::manufactured_errors;
use super::estimate::{Estimate, estimate, force_error};
use super::evaluate::{Context, Internal, internal};
use super::finite_strain::{deformed_pressure, jacobian_bound};
use super::increment::Ending;
use super::pressures::add_pressures;
use super::state::State;
use crate::assembly::grid::Rows;
use crate::contact::gap::linearise;
use crate::linalg::vector::{add_scaled, dot};
use crate::linalg::{LinearOperator, SparseRowsBuilder, Workspace};
use crate::plan::Plan;
use crate::report::{ObstacleResult, ProbeResult, StepReport, SupportResult, Termination};
use crate::scene::validate::ON_AXIS;

/// The report, without what only the session knows.
pub(crate) fn report(
    context: &Context<'_>,
    state: &State,
    ending: &Ending,
    counters: &Counters,
    work: &mut Workspace,
) -> StepReport {
    let units = &context.plan.units;
    let inside = internal(context, state, work);
    let estimated = reported_estimate(context, state, ending);
    let mut seconds = counters.seconds;
    let errors = timed(&mut seconds.error_norms, || {
        let field = context.plan.resolved.manufactured.as_ref()?;
        Some(manufactured_errors(context, state, field))
    });
    StepReport {
        step: 0,
        increment: 0,
        time: 0.0,
        load: state.drive.load,
        termination: ending.termination,
        cause: ending.cause,
        sqp_iterations: counters.sqp_iterations,
        krylov_iterations: counters.krylov_iterations,
        preconditioner_applications: counters.applications,
        eigenvalue_applications: counters.eigenvalue_applications,
        compliance_columns: 0,
        contact_products: counters.contact_products,
        active_set_changes: counters.set_changes,
        cut_backs: counters.cut_backs,
        factorisations: counters.factorisations,
        penalty: context.plan.penalty() + state.penalty(),
        active_vertices: state.active.iter().filter(|&&a| a).count() as u32,
        strain_energy: strain_energy(context, state, &inside, work) * units.energy(),
        volume_ratio: volume_ratio(context, state, &inside, work),
        min_jacobian: inside.response.map(|response| response.least_jacobian),
        min_jacobian_bound: jacobian_bound(context, state),
        stability: ending.stability,
        max_penetration: ending.max_penetration * units.length,
        residuals: ending.residuals,
        tolerance: ending.tolerance,
        obstacles: obstacles(context, state, estimated.as_ref()),
        supports: supports(context, state, inside.force),
        probes: probes(context, state),
        error_estimate: estimated.as_ref().map(|estimate| estimate.relative),
        errors,
        seconds,
        unknowns: context.plan.unknowns(),
        memory_bytes: 0,
        reused: Vec::new(),
        instruction_set: context.prepared.grid.instruction_set().name().to_owned(),
        verification: None,
    }
}

/// The estimate of a converged state, unless the scene wants none.
fn reported_estimate(context: &Context<'_>, state: &State, ending: &Ending) -> Option<Estimate> {
    let is_wanted =
        context.plan.scene.solver.error_estimate != "off" && context.prepared.strain.is_none();
    let is_there = ending.termination == Termination::Converged;
    (is_wanted && is_there).then(|| ending.estimate.unwrap_or_else(|| estimate(context, state)))
}

/// Stored energy: 1/2 u.(A u) + 1/2 p.(S p), or int W in the place of the first.
fn strain_energy(
    context: &Context<'_>,
    state: &State,
    inside: &Internal,
    work: &mut Workspace,
) -> f64 {
    let mut energy = match inside.response {
        Some(response) => response.energy,
        None => 0.5 * dot(&state.displacement, &inside.force),
    };
    let Some(block) = &context.prepared.pressure else {
        return energy;
    };
    let mut product = work.scratch(state.pressure.len());
    if inside.response.is_none() {
        // u.(B^T p) is taken off again: it vanishes at equilibrium only up to S.
        let grid = &context.prepared.grid;
        grid.divergence(Rows::All, &state.displacement, &mut product, work);
        energy -= 0.5 * dot(&product, &state.pressure);
    }
    if let Some(stabilisation) = &block.stabilisation {
        stabilisation.apply(&state.pressure, &mut product, work);
        energy += 0.5 * dot(&product, &state.pressure);
    }
    work.give(product);
    energy
}

/// Deformed over undeformed volume.
fn volume_ratio(
    context: &Context<'_>,
    state: &State,
    inside: &Internal,
    work: &mut Workspace,
) -> f64 {
    let volume: f64 = context.prepared.geometry.volumes.iter().sum();
    let change = match inside.response {
        Some(response) => response.volume_change,
        None => {
            // The hats sum to one, so the rows of B sum to -int div u.
            let mut rows = work.scratch(context.prepared.space.vertices);
            let grid = &context.prepared.grid;
            grid.divergence(Rows::All, &state.displacement, &mut rows, work);
            let change = -rows.iter().sum::<f64>();
            work.give(rows);
            change
        }
    };
    1.0 + change / volume
}

fn obstacles(
    context: &Context<'_>,
    state: &State,
    estimated: Option<&Estimate>,
) -> BTreeMap<String, ObstacleResult> {
    let force_unit = context.plan.units.force();
    let deformed = deformed_pressure(context, state);
    let touching = context.touching(state);
    touching.results(|index, interface, found, result| {
        result.force_error =
            estimated.map(|estimate| force_error(context, index, found, estimate) * force_unit);
        result.max_pressure_deformed = deformed.as_ref().map(|all| {
            let own = all[interface.range()].iter().copied();
            own.fold(0.0, f64::max)
        });
    })
}

/// Reactions: internal force plus contact minus load at held unknowns, given
/// to the support that holds them.
fn supports(
    context: &Context<'_>,
    state: &State,
    mut reaction: Vec<f64>,
) -> BTreeMap<String, SupportResult> {
    let load = state.drive.load;
    add_scaled(&mut reaction, -load, context.load);
    add_pressures(context, &state.displacement, -load, &mut reaction);
    add_contact_force(context, state, &mut reaction);
    let space = &context.prepared.space;
    let nodal = space.node_forces(&reaction);
    given_to_supports(context.plan, space.components, &nodal)
}

/// Forces on nodes, given to the supports that hold them.
pub(super) fn given_to_supports(
    plan: &Plan,
    components: usize,
    nodal: &[f64],
) -> BTreeMap<String, SupportResult> {
    let mut forces = vec![[0.0; 3]; plan.scene.supports.len()];
    for &(unknown, support) in &plan.held {
        let nodal = nodal.get(unknown as usize);
        // What the axis of a body of revolution holds is no support's.
        if let (Some(force), Some(nodal)) = (forces.get_mut(usize::from(support)), nodal) {
            force[unknown as usize % components] += nodal;
        }
    }
    let unit = plan.units.force();
    let names = plan.scene.supports.iter();
    names
        .zip(forces)
        .map(|(support, force)| {
            let force = force.map(|x| x * unit);
            (support.name.clone(), SupportResult { force })
        })
        .collect()
}

/// Adds C^T l with held columns kept.
fn add_contact_force(context: &Context<'_>, state: &State, force: &mut [f64]) {
    let body = context.deformed(&state.displacement);
    let obstacles = context
        .interfaces
        .obstacles(&state.drive, context.plan.units.length);
    let free = vec![false; force.len()];
    let mut builder = SparseRowsBuilder::new(force.len());
    for (interface, obstacle) in context.interfaces.list.iter().zip(&obstacles) {
        let mut part = linearise(&body, &interface.surface, obstacle, &free);
        part.rows.iter_mut().for_each(|row| builder.push_row(row));
    }
    let mut contact = vec![0.0; force.len()];
    let coupling = builder.finish();
    coupling.apply_transposed(&state.multiplier, &mut contact, &mut Workspace::new());
    add_scaled(force, 1.0, &contact);
}

fn probes(context: &Context<'_>, state: &State) -> BTreeMap<String, ProbeResult> {
    let units = &context.plan.units;
    let names = context.plan.scene.probes.iter();
    names
        .zip(&context.plan.resolved.probes)
        .map(|(probe, located)| {
            let cell = located.cell as usize;
            let displacement = displacement_at(context, state, cell, &located.barycentric);
            let pressure = (!state.pressure.is_empty()).then(|| {
                let corners = context.mesh.cell(cell).iter().zip(&located.barycentric);
                let value: f64 = corners.map(|(&v, l)| l * state.pressure[v as usize]).sum();
                value * units.stress
            });
            let result = ProbeResult {
                displacement: displacement.map(|x| x * units.length),
                pressure,
            };
            (probe.name.clone(), result)
        })
        .collect()
}

/// Displacement at barycentric coordinates of a cell, non-dimensional.
pub(super) fn displacement_at(
    context: &Context<'_>,
    state: &State,
    cell: usize,
    barycentric: &[f64; 4],
) -> [f64; 3] {
    let space = &context.prepared.space;
    let c = space.components;
    let mut value = [0.0; 3];
    let mut add = |node: usize, shape: f64| {
        for i in 0..c {
            value[i] += shape * state.displacement[node * c + i];
        }
    };
    for (&vertex, &l) in context.mesh.cell(cell).iter().zip(barycentric) {
        add(vertex as usize, l);
    }
    let pairs = context.mesh.cell_kind().edges();
    let edges = &context.mesh.cell_edges()[cell * pairs.len()..(cell + 1) * pairs.len()];
    for (&edge, &(a, b)) in edges.iter().zip(pairs) {
        add(
            space.vertices + edge as usize,
            4.0 * barycentric[a] * barycentric[b],
        );
    }
    value
}

/// Displacement gradient du_i/dx_j at barycentric coordinates of a cell.
pub(super) fn gradient_at(
    context: &Context<'_>,
    state: &State,
    cell: usize,
    barycentric: &[f64; 4],
) -> [[f64; 3]; 3] {
    let space = &context.prepared.space;
    let c = space.components;
    let g = context.prepared.geometry.gradients_of(cell);
    let mut gradient = [[0.0; 3]; 3];
    let mut add = |node: usize, slope: [f64; 3]| {
        for i in 0..c {
            for j in 0..3 {
                gradient[i][j] += state.displacement[node * c + i] * slope[j];
            }
        }
    };
    for (&vertex, slope) in context.mesh.cell(cell).iter().zip(g) {
        add(vertex as usize, *slope);
    }
    let pairs = context.mesh.cell_kind().edges();
    let edges = &context.mesh.cell_edges()[cell * pairs.len()..(cell + 1) * pairs.len()];
    for (&edge, &(a, b)) in edges.iter().zip(pairs) {
        let slope =
            std::array::from_fn(|j| 4.0 * (barycentric[a] * g[b][j] + barycentric[b] * g[a][j]));
        add(space.vertices + edge as usize, slope);
    }
    if context.plan.is_axisymmetric() {
        gradient[2][2] = match radius_at(context, cell, barycentric) {
            radius if radius > ON_AXIS => {
                displacement_at(context, state, cell, barycentric)[0] / radius
            }
            // Its limit.
            _ => gradient[0][0],
        };
    }
    gradient
}

/// x at barycentric coordinates of a cell, non-dimensional.
pub(super) fn radius_at(context: &Context<'_>, cell: usize, barycentric: &[f64; 4]) -> f64 {
    let corners = context.mesh.corners(cell);
    let sum: f64 = corners.iter().zip(barycentric).map(|(x, l)| l * x[0]).sum();
    context.plan.units.coordinate_scale * sum
}
