//! Estimate and bound of the discretisation error of a goal,
//!
//! ```text
//! eta_K = int_K (X* - X_h) : S : (Y* - Y_h)      J(x) - J(x_h) ~ sum of eta_K + sum of t_f
//! s_K   = int_K (H* - H_h) : A : (Z* - Z_h)
//! |J(x) - J(x_h)| <~ 6/5 sum over v of |sum over K at v of s_K / n| + 1/2 (|sum of t_f| + sum of |t_f|)
//! ```
//!
//! X = (H, p) the gradient of the displacement with the pressure, Y = (Z, q) those of the dual solution, both
//! recovered by patches ([`crate::assembly::recovery`]); S in the middle of the cell
//! ([`super::form`]), A its part of the gradients; v the vertices, n those of a cell; t_f what the edge of contact makes of faces that it crosses
//! ([`crate::contact::closing`]). These follow from
//!
//! ```text
//! J(x) - J(x_h) = S(x - x_h, y - y_h) + int l n . r_h + int m d_h
//! ```
//!
//! with the exact pressures l and m, gaps d_h and normal motions n . r_h at points: closed functions
//! see their means alone (R. Becker and R. Rannacher, Acta Numerica 10, 2001; A. Schroeder and A.
//! Rademacher, Comput. Methods Appl. Mech. Eng. 200, 2011). The sum with its signs is too little where
//! parts cancel that are not known so well; what recovered pressures and gradients make without signs in
//! cells is many times too much, for it oscillates from cell to cell: the bound takes the sizes around
//! each vertex, of gradients alone. It is shared out as the roots of the products of both errors by A in the cells
//! are, with the |t_f|. What edges make is taken in the middle of what it is with and without signs: both ends of a
//! punch make errors of either sign. The factor and the middle are measured, with `tests/benches/goals/bounds.py`: recovered
//! gradients see some four fifths of the error on uniform meshes, and more than it on graded ones. No
//! guarantee. The edges of contacts between bodies are left out. A fluid ends somewhere on the facets that
//! its front crosses: there the bound has what y does with its pressure, on the wet part or on the dry one.
//!
//! The energy is quadratic in the errors, and the y that is recovered that of dJ/dx at x, not at x_h:
//! half of S(e_x, e_x) is taken off. Where a body is led by displacements alone y is zero, and that is
//! all.
//!
//! Non-dimensional. Cost: two recoveries, one pass over the surfaces.

use super::form::Forms;
use super::freed::Freed;
use crate::assembly::recovery::{CellProducts, Recovery, cell_products};
use crate::contact::{Closing, closing};
use crate::model::Model;
use crate::model::fluids::front_works;
use crate::model::interfaces::Interface;
use crate::model::state::State;
use crate::report::GoalBound;
use crate::results::friction::tractions as tractions_at;

/// What sizes around vertices are taken times, without unit; of 1.0 to 1.5 the
/// least with 95 % of 276 bounds above their errors (`tests/benches/goals/bounds.py`).
const FACTOR: f64 = 1.2;

/// The error of one goal at a state, in the caller's units but for what the solver left.
pub(super) fn bound(model: &Model<'_>, state: &State, dual: &Freed<'_>) -> GoalBound {
    let unit = dual.unit();
    let smooth = dual.smooth(model);
    let products = goal_products(model, state, (dual, &smooth));
    let part = |one: &CellProducts| (one.own[0] * one.own[1]).abs().sqrt();
    let mut cells: Vec<f64> = products.iter().map(part).collect();
    let [mut edge, mut edge_sizes] = [0.0; 2];
    for (cell, own) in edges(model, state, (dual, &smooth)) {
        cells[cell] += own.abs();
        edge += own;
        edge_sizes += own.abs();
    }
    let mut front = 0.0;
    for (cell, own) in front_works(model, state, &smooth) {
        cells[cell] += own;
        front += own;
    }
    let inside: f64 = products.iter().map(|one| one.whole).sum();
    let total =
        FACTOR * around_vertices(model, &products) + 0.5 * (edge.abs() + edge_sizes) + front;
    share_out(total * unit, &mut cells);
    GoalBound {
        estimate: (inside + edge) * unit,
        discretisation: total * unit,
        geometry: dual.geometry(model, state),
        solver: 0.0,
        cells,
    }
}

/// The parts in the ratios that they have, with that sum.
fn share_out(total: f64, parts: &mut [f64]) {
    let sum: f64 = parts.iter().sum();
    let factor = if sum > 0.0 { total / sum } else { 0.0 };
    parts.iter_mut().for_each(|part| *part *= factor);
}

/// Sum over the vertices of the size of what the cells around each make of the gradients, each cell
/// shared out evenly among its vertices.
fn around_vertices(model: &Model<'_>, products: &[CellProducts]) -> f64 {
    let mut sums = vec![0.0; model.prepared.space.vertices];
    for (cell, product) in products.iter().enumerate() {
        let corners = model.mesh.cell(cell);
        for &corner in corners {
            sums[corner as usize] += product.gradients / corners.len() as f64;
        }
    }
    sums.iter().map(|sum: &f64| sum.abs()).sum()
}

/// Products of the errors of state and dual solution; of the energy less half of those of the state by
/// itself, its `own` with those.
fn goal_products(
    model: &Model<'_>,
    state: &State,
    (dual, smooth): (&Freed<'_>, &[f64]),
) -> Vec<CellProducts> {
    let mut all = products(model, state, (smooth, &dual.fields.pressure));
    if dual.is_energy() {
        let own = (&state.displacement[..], &state.pressure[..]);
        for (one, by_itself) in all.iter_mut().zip(products(model, state, own)) {
            one.whole -= 0.5 * by_itself.whole;
            one.gradients -= 0.5 * by_itself.gradients;
            one.own = one.own.map(|part| part + 0.5 * by_itself.gradients);
        }
    }
    all
}

/// Products of the errors of the state and of a dual solution `[cells]`.
fn products(
    model: &Model<'_>,
    state: &State,
    (smooth, dual_pressure): (&[f64], &[f64]),
) -> Vec<CellProducts> {
    let none = vec![[0.0; 2]; model.prepared.geometry.cells()];
    let recovery = |(displacement, pressure)| Recovery {
        mesh: model.mesh,
        scale: model.plan.problem.units.coordinate_scale,
        space: &model.prepared.space,
        geometry: &model.prepared.geometry,
        regions: &model.plan.problem.resolved.cell_material,
        moduli: &none,
        displacement,
        pressure,
    };
    let own = recovery((&state.displacement, &state.pressure));
    let dual = recovery((smooth, dual_pressure));
    let forms = Forms::new(model, state);
    cell_products([&own, &dual], &|cell| forms.of(cell))
}

/// t_f of the faces that the edges of contact with obstacles cross, with their cells.
fn edges(
    model: &Model<'_>,
    state: &State,
    (dual, smooth): (&Freed<'_>, &[f64]),
) -> Vec<(usize, f64)> {
    let body = model.deformed(&state.displacement);
    let is_closed = |status: &crate::saddle::Status| f64::from(u8::from(status.is_closed()));
    let closed: Vec<f64> = state.status.iter().map(is_closed).collect();
    let tractions = tractions(model, state);
    let mut parts = Vec::new();
    for (index, (interface, met)) in model.placed(&state.drive).enumerate() {
        if met.obstacle().is_none() {
            continue;
        }
        let at = Closing {
            closed: &interface.coefficients(&closed),
            pressure: &interface.coefficients(&state.multiplier),
            traction: &coefficients(interface, &tractions),
            dual: &interface.coefficients(&dual.fields.multiplier),
            motion: &dual.relative((model, state), (index, smooth)),
        };
        let own = closing(&body, &interface.surface, &met, at);
        let cells = interface.facets.iter();
        let cells = cells.map(|&facet| model.mesh.facet_cell(facet as usize).0);
        parts.extend(cells.zip(own).filter(|(_, part)| *part != 0.0));
    }
    parts
}

/// Tractions of friction along the axes, each at the multipliers of its pressures `[3][multipliers]`;
/// none without friction.
fn tractions(model: &Model<'_>, state: &State) -> Option<[Vec<f64>; 3]> {
    let friction = model.interfaces.friction.as_ref()?;
    let frames = friction.frames(model, state);
    let mut all = std::array::from_fn(|_| vec![0.0; state.multiplier.len()]);
    let points = friction.partners.iter();
    for (&partner, traction) in points.zip(tractions_at(friction, &frames, state)) {
        let sums: &mut [Vec<f64>; 3] = &mut all;
        for (sum, value) in sums.iter_mut().zip(traction) {
            sum[partner as usize] += value;
        }
    }
    Some(all)
}

/// What the functions of a surface have of the tractions `[functions][3]`; empty without friction.
fn coefficients(interface: &Interface, tractions: &Option<[Vec<f64>; 3]>) -> Vec<[f64; 3]> {
    let Some(all) = tractions else {
        return Vec::new();
    };
    let [x, y, z] = all.each_ref().map(|own| interface.coefficients(own));
    let parts = x.into_iter().zip(y).zip(z);
    parts.map(|((x, y), z)| [x, y, z]).collect()
}
