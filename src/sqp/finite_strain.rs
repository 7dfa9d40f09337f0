//! What results say of a body of rubber, cell by cell:
//!
//! ```text
//! sigma = P F^T / J,   J averaged over a cell,   a number that J is nowhere below
//! ```
//!
//! in the caller's units; contact pressure per deformed area. None of it where the
//! scene is linear. Cost: four gradients a cell.

use super::evaluate::Context;
use super::loads::simplices;
use super::results::gradient_at;
use super::state::State;
use crate::element::jacobian::{least_jacobian_bound, sharper_jacobian_bound};
use crate::element::quadrature::rule;
use crate::geometry::tensor::{Tensor, plus_unit, product, scaled, transposed, volume_change};
use crate::material::Rubber;

/// J is a cubic polynomial on a cell.
const JACOBIAN_DEGREE: u32 = 3;

/// The rubber of a cell; none in linear scenes.
pub(super) fn rubber<'a>(context: &Context<'a>, cell: usize) -> Option<&'a Rubber> {
    let resolved = &context.plan.resolved;
    let material = &resolved.materials[usize::from(resolved.cell_material[cell])];
    material.rubber.as_ref()
}

/// True stress at displacement gradient `h` under internal pressure `pressure`.
pub(super) fn true_stress(rubber: &Rubber, h: &Tensor<f64>, pressure: f64) -> Tensor<f64> {
    let (gradient, jacobian) = (plus_unit(h), 1.0 + volume_change(h));
    let nominal = rubber.stress(h, pressure);
    scaled(jacobian.recip(), &product(&nominal, &transposed(&gradient)))
}

/// Deformed over undeformed volume of a cell.
pub(super) fn volume_ratio(context: &Context<'_>, state: &State, cell: usize) -> f64 {
    let (simplex, _) = simplices(context.plan.units.dimension);
    let rule = rule(simplex, JACOBIAN_DEGREE);
    let points = rule.points.iter().zip(&rule.weights);
    let change = points
        .map(|(point, weight)| weight * volume_change(&gradient_at(context, state, cell, point)));
    1.0 + change.sum::<f64>()
}

/// A number that J is nowhere in the body below; none in linear scenes.
pub(super) fn jacobian_bound(context: &Context<'_>, state: &State) -> Option<f64> {
    if !context.plan.resolved.is_rubber() {
        return None;
    }
    let cells = 0..context.mesh.cell_count();
    let bounds = cells.map(|cell| cell_bound(context, state, cell));
    bounds.reduce(|a, b| if a.is_nan() || a < b { a } else { b })
}

/// The plain bound where it shows that J is above zero, else the sharper one.
fn cell_bound(context: &Context<'_>, state: &State, cell: usize) -> f64 {
    let corners = context.mesh.cell(cell).len();
    let mut gradients = [[[0.0; 3]; 3]; 4];
    for (corner, gradient) in gradients.iter_mut().enumerate().take(corners) {
        let mut at = [0.0; 4];
        at[corner] = 1.0;
        *gradient = plus_unit(&gradient_at(context, state, cell, &at));
    }
    let plain = least_jacobian_bound(&gradients[..corners]);
    match plain > 0.0 {
        true => plain,
        false => sharper_jacobian_bound(&gradients[..corners]),
    }
}

/// Contact pressure per deformed area on all multipliers; none in linear scenes.
pub(super) fn deformed_pressure(context: &Context<'_>, state: &State) -> Option<Vec<f64>> {
    if !context.plan.resolved.is_rubber() {
        return None;
    }
    let body = context.deformed(&state.displacement);
    let unit = context.plan.units.stress;
    let interfaces = context.interfaces.list.iter();
    let all = interfaces.flat_map(|interface| {
        let pressure = &state.multiplier[interface.range()];
        interface.surface.deformed_pressure(&body, pressure)
    });
    Some(all.map(|pressure| pressure * unit).collect())
}
