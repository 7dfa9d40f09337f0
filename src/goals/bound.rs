//! Estimate and bound of the discretisation error of a goal,
//!
//! ```text
//! eta_K = int_K (X* - X_h) : S : (Y* - Y_h)      J(x) - J(x_h) ~ sum of eta_K + sum of t_f
//! b_K = sqrt(|S| (X* - X_h)^2 |S| (Y* - Y_h)^2)
//! |J(x) - J(x_h)| <~ |sum of eta_K + sum of t_f| + 1/2 (sum of b_K + sum of |t_f|)
//! ```
//!
//! X the gradient of the displacement with the pressure, Y those of the dual solution, both
//! recovered by patches ([`crate::assembly::recovery`]); S in the middle of the cell
//! ([`super::form`]); t_f what the edge of contact makes of faces that it crosses
//! ([`crate::contact::closing`]). These follow from
//!
//! ```text
//! J(x) - J(x_h) = S(x - x_h, y - y_h) + int l n . r_h + int m d_h
//! ```
//!
//! with the exact pressures l and m, gaps d_h and normal motions n . r_h at points: closed functions
//! see their means alone (R. Becker and R. Rannacher, Acta Numerica 10, 2001; A. Schroeder and A.
//! Rademacher, Comput. Methods Appl. Mech. Eng. 200, 2011). What all parts make with their signs is
//! too little on coarse meshes, what they make without signs is four times too much: the bound is
//! the first and half of the second, shared out as the parts without signs are (measured, with
//! `tests/benches/goals/bounds.py`). Where all parts have one sign, as of a force along the only load, recovered
//! gradients see some two thirds of the error: the half is what is missing there. No guarantee. The edges of contacts between bodies are left
//! out.
//!
//! The energy is quadratic in the errors, and the y that is recovered that of dJ/dx at x, not at x_h:
//! half of S(e_x, e_x) is taken off. Where a body is led by displacements alone y is zero, and that is
//! all.
//!
//! Non-dimensional. Cost: two recoveries, of rubber an eigenvalue problem of ten a cell, one pass
//! over the surfaces.

use super::form::Forms;
use super::freed::Freed;
use crate::assembly::recovery::{Recovery, cell_products};
use crate::contact::{Closing, closing};
use crate::model::Model;
use crate::model::interfaces::Interface;
use crate::model::state::State;
use crate::report::GoalBound;
use crate::results::friction::tractions as tractions_at;

/// The error of one goal at a state, in the caller's units but for what the solver left.
pub(super) fn bound(model: &Model<'_>, state: &State, dual: &Freed<'_>) -> GoalBound {
    let unit = dual.unit();
    let smooth = dual.smooth(model);
    let both = products(model, state, (&smooth, &dual.fields.pressure));
    let part = |[_, own, dual]: &[f64; 3]| (own.max(0.0) * dual.max(0.0)).sqrt();
    let mut cells: Vec<f64> = both.iter().map(part).collect();
    let mut estimate: f64 = both.iter().map(|[signed, ..]| signed).sum();
    if dual.is_energy() {
        let own = (&state.displacement[..], &state.pressure[..]);
        for (cell, [signed, ..]) in cells.iter_mut().zip(products(model, state, own)) {
            *cell += 0.5 * signed.abs();
            estimate -= 0.5 * signed;
        }
    }
    for (cell, own) in edges(model, state, (dual, &smooth)) {
        cells[cell] += own.abs();
        estimate += own;
    }
    let share = share(estimate.abs(), cells.iter().sum());
    cells.iter_mut().for_each(|part| *part *= share * unit);
    GoalBound {
        estimate: estimate * unit,
        discretisation: cells.iter().sum(),
        geometry: dual.geometry(model, state),
        solver: 0.0,
        cells,
    }
}

/// What parts make `with_signs` and half of what they make `without`, over the latter.
fn share(with_signs: f64, without: f64) -> f64 {
    if without > 0.0 {
        0.5 + with_signs / without
    } else {
        1.0
    }
}

/// eta_K and both factors of b_K `[cells][3]`.
fn products(
    model: &Model<'_>,
    state: &State,
    (smooth, dual_pressure): (&[f64], &[f64]),
) -> Vec<[f64; 3]> {
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
