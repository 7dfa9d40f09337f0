//! From a state to the report of an increment, in the caller's units.
//!
//! ```text
//! energy = int W dx,   volume ratio = int J dx / int dx,   reaction = internal force less load in held rows
//! ```
//!
//! Forces, areas and energies are brought from the solver's units, modulus and length, to
//! the caller's. Cost: one evaluation of the body and one probe a face point.

use std::collections::BTreeMap;

use crate::assembly::grid::Rows;
use crate::linalg::Workspace;
use crate::model::Model;
use crate::model::counters::{Counters, timed};
use crate::model::ending::Ending;
use crate::model::ending::Estimate;
use crate::model::energy::strain_energy;
use crate::model::internal::Internal;
use crate::model::internal::internal;
use crate::model::state::State;
use crate::model::values::displacement_at;
use crate::report::{BodyContactResult, ObstacleResult, ProbeResult, StepReport, Termination};
use crate::results::errors::manufactured_errors;
use crate::results::estimate::{estimate, force_error};
use crate::results::fields::{is_sheet, jacobian, pressure_share};
use crate::results::finite_strain::{jacobian_bound, undeformed_pressure};
use crate::results::fluids;
use crate::results::friction::{add_friction, add_friction_between};
use crate::results::geometry_error::geometry_error;
use crate::results::reactions::reactions;
use crate::results::ties;
use crate::results::touch::{Touch, pressed_facets};
use crate::results::touching::Touching;

/// The report, without what only the session knows.
pub(crate) fn report(
    model: &Model<'_>,
    state: &State,
    ending: &Ending,
    counters: &Counters,
    work: &mut Workspace,
) -> StepReport {
    let units = &model.plan.problem.units;
    let inside = internal(model, state, work);
    let estimated = reported_estimate(model, state, ending);
    let mut seconds = counters.seconds;
    let errors = timed(&mut seconds.error_norms, || {
        let field = model.plan.problem.resolved.manufactured.as_ref()?;
        Some(manufactured_errors(model, state, field))
    });
    StepReport {
        penalty: model.plan.penalty() + state.penalty,
        active_vertices: model.interfaces.contacts_at_work(state) as u32,
        strain_energy: strain_energy(model, state, &inside, work) * units.energy(),
        volume_ratio: volume_ratio(model, state, &inside, work),
        min_jacobian: inside.response.map(|response| response.least_jacobian),
        min_jacobian_bound: jacobian_bound(model, state),
        stability: ending.stability,
        cause_site: ending.site.map(|site| site.in_words_of(model.plan)),
        snapped: ending.snapped.map(|snap| snap.in_units(units)),
        max_penetration: ending.max_penetration * units.length,
        obstacles: obstacles(model, state, estimated.as_ref()),
        contacts: contacts(model, state),
        ties: ties::results(model, state),
        supports: reactions(model, state, inside.force),
        fluids: fluids::results(model, state, ending, counters.fluid_rounds),
        probes: probes(model, state),
        error_estimate: estimated.as_ref().map(|estimate| estimate.relative),
        errors,
        seconds,
        unknowns: model.plan.unknowns(),
        instruction_set: model.prepared.grid.instruction_set().name().to_owned(),
        ..counted(state, ending, counters)
    }
}

/// What every body reports alike: the end that its increment came to, its counts and its
/// seconds. The rest is the body's, or the session's.
pub(crate) fn counted(state: &State, ending: &Ending, counters: &Counters) -> StepReport {
    StepReport {
        load: state.drive.load,
        termination: ending.termination,
        cause: ending.cause,
        sqp_iterations: counters.sqp_iterations,
        krylov_iterations: counters.krylov_iterations,
        preconditioner_applications: counters.applications,
        eigenvalue_applications: counters.eigenvalue_applications,
        contact_products: counters.contact_products,
        active_set_changes: counters.set_changes,
        newton_steps: counters.newton_steps,
        threshold_passes: counters.threshold_passes,
        cut_backs: counters.cut_backs,
        attempts: counters.attempts.clone(),
        factorisations: counters.factorisations,
        residuals: ending.residuals,
        tolerance: ending.tolerance,
        seconds: counters.seconds,
        ..StepReport::default()
    }
}

/// The estimate of a converged state, unless the scene wants none.
fn reported_estimate(model: &Model<'_>, state: &State, ending: &Ending) -> Option<Estimate> {
    let is_wanted = model.plan.problem.settings.estimates_error && model.prepared.strain.is_none();
    let is_there = ending.termination == Termination::Converged;
    (is_wanted && is_there).then(|| {
        let known = ending.estimate.clone();
        known.unwrap_or_else(|| estimate(model, state))
    })
}

/// Deformed over undeformed volume.
fn volume_ratio(model: &Model<'_>, state: &State, inside: &Internal, work: &mut Workspace) -> f64 {
    let volumes = &model.prepared.geometry.volumes;
    let volume: f64 = volumes.iter().sum();
    if is_sheet(model) {
        let cells = volumes.iter().enumerate();
        let whole = cells.map(|(cell, volume)| volume * jacobian(model, state, cell));
        return whole.sum::<f64>() / volume;
    }
    let change = match inside.response {
        Some(response) => response.volume_change,
        None => {
            // The hats sum to one, so the rows of B sum to -int div u.
            let mut rows = work.scratch(model.prepared.space.vertices);
            let grid = &model.prepared.grid;
            grid.divergence(Rows::All, &state.displacement, &mut rows, work);
            let change = -rows.iter().sum::<f64>();
            work.give(rows);
            change
        }
    };
    1.0 + change / volume
}

/// Resultants of every obstacle by name, in the caller's units, with the estimated
/// error of each force.
fn obstacles(
    model: &Model<'_>,
    state: &State,
    estimated: Option<&Estimate>,
) -> BTreeMap<String, ObstacleResult> {
    let force_unit = model.plan.problem.units.force();
    let undeformed = undeformed_pressure(model, state);
    let touching = Touching::of(model, state);
    let places = model.interfaces.list.iter().enumerate();
    let places: BTreeMap<&str, usize> = places.map(|(at, one)| (&*one.name, at)).collect();
    let mut results = touching.results(|interface, found, result| {
        result.force_error = estimated.map(|estimate| {
            let pressed = pressed_facets(interface, state);
            force_error(model, (found, &pressed), estimate) * force_unit
        });
        result.geometry_error = geometry_error(model, state, interface);
        let own = undeformed
            .as_ref()
            .map(|all| &all[places[&*interface.name]]);
        result.max_pressure_undeformed = own.map(|own| interface.surface.largest(own));
        result.max_pressure_deformed = own.map(|_| result.max_pressure);
    });
    add_friction(model, state, &mut results);
    results
}

/// Results of all contacts between bodies.
fn contacts(model: &Model<'_>, state: &State) -> BTreeMap<String, BodyContactResult> {
    let mut results = Touching::of(model, state).between_bodies();
    add_friction_between(model, state, &mut results);
    results
}

/// Adds to the error of each force what overlaps hide that no function of contact feels.
pub(crate) fn add_hidden_forces(
    model: &Model<'_>,
    touches: &[Touch<'_>],
    results: &mut BTreeMap<String, ObstacleResult>,
) {
    for touch in touches {
        let result = results.get_mut(&*touch.interface.name);
        if let Some(error) = result.and_then(|result| result.force_error.as_mut()) {
            *error += touch.hidden_force(model) * model.plan.problem.units.force();
        }
    }
}

/// Displacement and pressure at every probe by name, in the caller's units.
fn probes(model: &Model<'_>, state: &State) -> BTreeMap<String, ProbeResult> {
    let units = &model.plan.problem.units;
    let probes = model.plan.problem.resolved.probes.iter();
    probes
        .map(|probe| {
            let located = &probe.place;
            let cell = located.cell as usize;
            let displacement = displacement_at(model, state, cell, &located.barycentric);
            let pressure = (!state.pressure.is_empty()).then(|| {
                let corners = model.mesh.cell(cell).iter().zip(&located.barycentric);
                let value: f64 = corners.map(|(&v, l)| l * state.pressure[v as usize]).sum();
                value * units.stress * pressure_share(model, cell)
            });
            let result = ProbeResult {
                displacement: displacement.map(|x| x * units.length),
                pressure,
            };
            (probe.name.clone(), result)
        })
        .collect()
}
