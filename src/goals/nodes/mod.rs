//! Derivatives of goals by the places of all vertices of the mesh,
//!
//! ```text
//! dJ/dX = d/dX [J(x, X) + y . R(x, X)] at fixed x
//! ```
//!
//! x the coefficients of displacement and pressure and the multipliers: the fields move with the
//! vertices. What depends on the deformed places alone (gaps, areas of finite strain, pressures that
//! follow) depends on a vertex as it does on its displacement; cells and undeformed areas have terms
//! of their own ([`cells`], [`areas`]). `[vertices][3]`, in the caller's units. Bodies without
//! friction, of straight cells, on supports of constant values.
//!
//! Cost: one pass over cells and surfaces a goal.

mod areas;
mod cells;

use super::dual::Dual;
use super::error::GoalError;
use super::own_contact::OwnContact;
use crate::contact::gap::linearise;
use crate::contact::{FaceFields, curvature};
use crate::geometry::vector3::{add, scale};
use crate::linalg::vector::add_scaled;
use crate::linalg::{LinearOperator, Workspace};
use crate::model::Model;
use crate::model::pressures::pressed_tangent;
use crate::model::state::State;
use crate::scene::SceneKind;

/// Derivative by the places of the vertices.
pub(super) type ByNodes = Vec<[f64; 3]>;

/// Refuses meshes and scenes whose dependence on places is not known here.
///
/// # Errors
/// [`GoalError::Absent`] with the cause.
pub(super) fn refuse(model: &Model<'_>, state: &State) -> Result<(), GoalError> {
    let problem = &model.plan.problem;
    let resolved = &problem.resolved;
    let mut supports = resolved.supports.iter();
    let is_varied = supports.any(|one| one.profile.is_some() || one.normal.is_some());
    let turns = state.drive.motions.iter();
    let causes = [
        (
            problem.obstacles.iter().any(|one| one.is_frictional),
            "friction",
        ),
        (!model.mesh.edge_offsets().is_empty(), "curved edges"),
        (resolved.kind == SceneKind::PlaneStress, "plane stress"),
        (resolved.manufactured.is_some(), "a manufactured field"),
        (
            model.plan.penalty() != 0.0,
            "a volume term of the scene's own",
        ),
        (is_varied, "supports of a profile or along a normal"),
        (
            turns
                .clone()
                .any(|motion| motion.rotation.iter().any(|x| *x != 0.0)),
            "supports that turn",
        ),
        (!problem.held_nodes.is_empty(), "supports of oblique planes"),
        (!state.drive.given.is_at_rest(), "values of other codes"),
        (!resolved.fluids.is_empty(), "fluids"),
        (!problem.ties.is_empty(), "ties"),
        (!problem.pairs.is_empty(), "contact between bodies"),
    ];
    let mut causes = causes.into_iter();
    match causes.find(|(is_there, _)| *is_there) {
        None => Ok(()),
        Some((_, what)) => Err(GoalError::Absent {
            text: "mesh".to_owned(),
            cause: format!("derivatives by the places of nodes are not known with {what}"),
        }),
    }
}

/// dJ/dX of one goal.
pub(super) fn by_nodes(model: &Model<'_>, state: &State, dual: &Dual) -> ByNodes {
    let mut motion = dual.fields.displacement.clone();
    dual.goal.add_support_motion(model, -1.0, &mut motion);
    let mut sums = vec![[0.0; 3]; model.prepared.space.vertices];
    cells::add_cells(model, state, (dual, &motion), &mut sums);
    add_contact(model, state, (dual, &motion), &mut sums);
    add_loads(model, state, &motion, &mut sums);
    dual.goal.add_place(model, state, &mut sums);
    let unit = dual.goal.unit() * model.plan.problem.units.coordinate_scale;
    sums.iter_mut().for_each(|sum| *sum = scale(unit, *sum));
    sums
}

/// Adds what a field of displacements has at vertices.
fn add_vertices(model: &Model<'_>, field: &[f64], sums: &mut [[f64; 3]]) {
    let rows = field.chunks_exact(model.prepared.space.components);
    for (sum, row) in sums.iter_mut().zip(rows) {
        sum.iter_mut()
            .zip(row)
            .for_each(|(sum, value)| *sum += value);
    }
}

/// m . g - l . C v of all surfaces: by deformed places as by the displacement, and by undeformed
/// areas.
fn add_contact(
    model: &Model<'_>,
    state: &State,
    (dual, motion): (&Dual, &[f64]),
    sums: &mut [[f64; 3]],
) {
    let body = model.deformed(&state.displacement);
    let free = vec![false; motion.len()];
    let work = &mut Workspace::new();
    for (index, (interface, met)) in model.placed(&state.drive).enumerate() {
        let mut along = motion.to_vec();
        let own = dual.goal.of_own_motion(model, state, index);
        if let Some(own) = &own {
            add_scaled(&mut along, 1.0, own);
        }
        let mut field = vec![0.0; motion.len()];
        let rows = linearise(&body, &interface.surface, &met, &free).rows;
        for (place, row) in interface.places().zip(rows) {
            for (unknown, value) in row {
                field[unknown as usize] -= dual.fields.multiplier[place] * value;
            }
        }
        if !model.is_linear() {
            let pressure = interface.own(&state.multiplier);
            let bent = curvature(&body, &[(&interface.surface, &met, &pressure[..])], &free);
            let mut product = vec![0.0; motion.len()];
            bent.apply_transposed(&along, &mut product, work);
            add_scaled(&mut field, 1.0, &product);
        }
        if own.is_some() {
            let contact = OwnContact::new(model, state, index);
            let force = contact.map(|contact| contact.force(state));
            dual.goal
                .add_turned(model, &force.unwrap_or_default(), &mut field);
        }
        add_vertices(model, &field, sums);
        if !model.is_rubber() {
            let at = FaceFields {
                pressure: &interface.coefficients(&state.multiplier),
                dual: &interface.coefficients(&dual.fields.multiplier),
                motion: &along,
            };
            areas::add_contact(&body, (&interface.surface, &met), at, sums);
        }
    }
}

/// z . f of dead tractions and of pressures that follow.
fn add_loads(model: &Model<'_>, state: &State, motion: &[f64], sums: &mut [[f64; 3]]) {
    let free = vec![false; motion.len()];
    if let Some(tangent) = pressed_tangent(model, state, &free) {
        let mut field = vec![0.0; motion.len()];
        tangent.apply_transposed(motion, &mut field, &mut Workspace::new());
        add_vertices(model, &field, sums);
    }
    areas::add_tractions(model, state, motion, sums);
}

/// Adds a share of a vector.
fn add_share(sum: &mut [f64; 3], share: f64, vector: [f64; 3]) {
    *sum = add(*sum, scale(share, vector));
}
